//! Time against error as a picture: both axes logarithmic, one mark a configuration, the Pareto front as steps.

use super::{Point, name, pareto, three_figures};
use crate::stages::{Bound, Grid};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::{ops::Range, path::Path, sync::Once};
use thiserror::Error;

/// Why a plot could not be made.
#[derive(Debug, Error)]
pub enum PlotError {
    #[error("nothing to plot: no configuration drew all views and was checked")]
    Empty,
    #[error("plot: {0}")]
    Drawing(String),
}

/// Image size in pixels.
const SIZE: (u32, u32) = (1200, 750);
/// What the contract of DESIGN section 4 allows, in pixels.
const CONTRACT: f64 = 0.5;
/// Errors below this are drawn here; a logarithm needs a floor, and nothing below is visible.
const LEAST_ERROR: f64 = 1e-4;
const MARK: f64 = 7.0;
const FRONT: RGBColor = RGBColor(90, 90, 90);
const LIMIT: RGBColor = RGBColor(200, 30, 30);
const FONT: &str = "sans-serif";

type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<LogAxis, LogAxis>>;
type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// Writes the plot as PNG.
pub fn plot_png(path: &Path, title: &str, points: &[Point]) -> Result<(), PlotError> {
    plot(|| BitMapBackend::new(path, SIZE), title, points)
}

/// Writes the plot as SVG.
pub fn plot_svg(path: &Path, title: &str, points: &[Point]) -> Result<(), PlotError> {
    plot(|| SVGBackend::new(path, SIZE), title, points)
}

/// A backend writes its file even when nothing was drawn, so it is made once there is something to draw.
fn plot<DB: DrawingBackend>(backend: impl FnOnce() -> DB, title: &str, points: &[Point]) -> Result<(), PlotError> {
    if points.is_empty() {
        return Err(PlotError::Empty);
    }
    use_bundled_font()?;
    let area = backend().into_drawing_area();
    let done = draw(&area, title, points).and_then(|()| area.present());
    done.map_err(|e| PlotError::Drawing(e.to_string()))
}

/// Labels need a font on machines that have none.
fn use_bundled_font() -> Result<(), PlotError> {
    static ONCE: Once = Once::new();
    let mut result = Ok(());
    ONCE.call_once(|| {
        result = plotters::style::register_font(FONT, FontStyle::Normal, dejavu::sans::regular())
            .map_err(|_| PlotError::Drawing("the bundled font is damaged".into()));
    });
    result
}

fn draw<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, title: &str, points: &[Point]) -> Drawn<DB> {
    area.fill(&WHITE)?;
    let (plot, legend) = area.split_horizontally(SIZE.0 - 220);
    let x = LogAxis::around(points.iter().map(|p| p.ms));
    let y = LogAxis::around(points.iter().map(|p| shown_error(p.error)).chain([CONTRACT]));
    let mut chart = ChartBuilder::on(&plot)
        .caption(title, (FONT, 22))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(76)
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .max_light_lines(0)
        .bold_line_style(RGBColor(225, 225, 225))
        .label_style((FONT, 15))
        .axis_desc_style((FONT, 16))
        .x_desc("frame time, ms (mean of the views' medians)")
        .y_desc("largest grid error, px")
        .draw()?;
    draw_contract(&mut chart, &x)?;
    draw_front(&mut chart, &pareto(points), &x, &y)?;
    for point in points {
        draw_point(&chart, point)?;
    }
    draw_legend(&legend, points)
}

fn draw_contract<DB: DrawingBackend>(chart: &mut Chart<'_, DB>, x: &LogAxis) -> Drawn<DB> {
    let y = CONTRACT;
    chart.draw_series([PathElement::new([(x.low, y), (x.high, y)], LIMIT.stroke_width(2))])?;
    let style = (FONT, 15).into_font().color(&LIMIT).pos(Pos::new(HPos::Right, VPos::Bottom));
    let label = EmptyElement::at((x.high, y)) + Text::new("the contract: 0.5 px", (-6, -3), style);
    chart.plotting_area().draw(&label)
}

/// With this much time, that error: down to each point, then right until the next is affordable.
fn draw_front<DB: DrawingBackend>(chart: &mut Chart<'_, DB>, front: &[Point], x: &LogAxis, y: &LogAxis) -> Drawn<DB> {
    let mut path = Vec::new();
    let mut level = y.high;
    for at in front.iter().map(position) {
        path.extend([(at.0, level), at]);
        level = at.1;
    }
    path.push((x.high, level));
    chart.draw_series([PathElement::new(path, FRONT.stroke_width(2))])?;
    Ok(())
}

fn draw_point<DB: DrawingBackend>(chart: &Chart<'_, DB>, point: &Point) -> Drawn<DB> {
    let (area, at) = (chart.plotting_area(), position(point));
    draw_mark(area, at, point.bound, point.grid)?;
    let style = (FONT, 14).into_font().color(&color(point.bound)).pos(Pos::new(HPos::Left, VPos::Bottom));
    area.draw(&(EmptyElement::at(at) + Text::new(point.tolerance.to_string(), (MARK as i32, -MARK as i32 + 2), style)))
}

/// The bound's shape in its colour: full for grids of any size, hollow for ETER's.
fn draw_mark<DB: DrawingBackend, CT: CoordTranslate>(
    area: &DrawingArea<DB, CT>,
    at: CT::From,
    bound: Bound,
    grid: Grid,
) -> Drawn<DB>
where
    CT::From: Clone,
{
    let mut outline = shape(bound);
    if !matches!(grid, Grid::Eter | Grid::Eter16) {
        area.draw(&(EmptyElement::at(at.clone()) + Polygon::new(outline.clone(), color(bound).filled())))?;
    }
    outline.push(outline[0]);
    area.draw(&(EmptyElement::at(at) + PathElement::new(outline, color(bound).stroke_width(2))))
}

fn draw_legend<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, points: &[Point]) -> Drawn<DB> {
    let mut line = 0;
    let mut next = || {
        line += 1;
        (24, 40 + 28 * line)
    };
    let style = (FONT, 16).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
    let text = |at: (i32, i32), text: String| area.draw(&Text::new(text, (at.0 + 18, at.1), style.clone()));
    for bound in Bound::ALL.into_iter().filter(|b| points.iter().any(|p| p.bound == *b)) {
        let at = next();
        draw_mark(area, at, bound, Grid::Variable)?;
        text(at, name(bound))?;
    }
    if points.iter().any(|p| p.grid == Grid::Eter) {
        text(next(), "hollow: ETER's 8x8 grid".into())?;
    }
    let at = next();
    area.draw(&PathElement::new([(at.0 - 10, at.1), (at.0 + 10, at.1)], FRONT.stroke_width(2)))?;
    text(at, "Pareto front".into())?;
    text(next(), "number: tolerance, px".into())
}

/// Corners about (0, 0) in pixels.
fn shape(bound: Bound) -> Vec<(i32, i32)> {
    let polygon = |corners: u32, turn: f64, radius: f64| {
        let corner = |i: u32| (f64::from(i) / f64::from(corners) + turn) * std::f64::consts::TAU;
        (0..corners)
            .map(|i| ((radius * corner(i).cos()).round() as i32, (radius * corner(i).sin()).round() as i32))
            .collect()
    };
    match bound {
        Bound::Screen => polygon(24, 0.0, MARK),
        Bound::Eter => polygon(4, 0.125, MARK * 1.2),
        Bound::Filip => polygon(3, 0.75, MARK * 1.3),
        Bound::Projective => polygon(4, 0.0, MARK * 1.3),
        Bound::Slefe => polygon(3, 0.25, MARK * 1.3),
    }
}

/// Okabe and Ito's palette, told apart by the colour-blind too.
fn color(bound: Bound) -> RGBColor {
    match bound {
        Bound::Screen => RGBColor(0, 114, 178),
        Bound::Eter => RGBColor(213, 94, 0),
        Bound::Filip => RGBColor(0, 158, 115),
        Bound::Projective => RGBColor(204, 121, 167),
        Bound::Slefe => RGBColor(120, 120, 120),
    }
}

fn position(point: &Point) -> (f64, f64) {
    (point.ms, shown_error(point.error))
}

fn shown_error(error: f64) -> f64 {
    error.max(LEAST_ERROR)
}

/// A logarithmic axis with ticks at 1, 2 and 5 times the powers of ten.
#[derive(Clone, Debug)]
struct LogAxis {
    low: f64,
    high: f64,
}

impl LogAxis {
    /// From the least to the largest value, with a margin.
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0f64), |(lo, hi), v| (lo.min(v), hi.max(v)));
        // Times of nothing at all are zero.
        let (low, high) = (low.max(1e-9), high.max(1e-9));
        let margin = (high / low).powf(0.08).max(1.25);
        Self { low: low / margin, high: high * margin }
    }

    /// 1, 2 and 5 times the powers of ten, or those powers alone where there are many.
    fn ticks(&self) -> Vec<f64> {
        let steps: &[f64] = if self.high / self.low > 300.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all = decades.flat_map(|decade| steps.iter().map(move |s| s * 10f64.powi(decade)));
        all.filter(|t| (self.low..=self.high).contains(t)).collect()
    }
}

impl Ranged for LogAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let along = (value / self.low).ln() / (self.high / self.low).ln();
        limit.0 + (along * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for LogAxis {
    fn format_ext(&self, value: &f64) -> String {
        plain(*value)
    }
}

/// 1, 2 or 5 times a power of ten without trailing zeros behind the point.
fn plain(x: f64) -> String {
    let text = three_figures(x);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{points, testing::row};

    fn sample() -> Vec<Point> {
        let mut rows = Vec::new();
        for (i, bound) in Bound::ALL.into_iter().enumerate() {
            for (grid, slower) in [(Grid::Variable, 1.0), (Grid::Eter, 3.1)] {
                for (t, factor) in [(0.25, 2.3), (0.5, 1.3), (1.0, 0.8)] {
                    let slack = 1.05 + 0.35 * i as f64;
                    rows.push(row(bound, grid, t, 20.0 * slack * slower * factor, t / slack / slower.sqrt()));
                }
            }
        }
        points(&rows)
    }

    #[test]
    fn both_formats_draw() {
        let dir = std::env::temp_dir().join(format!("halfpixel-plot-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let (svg, png) = (dir.join("plot.svg"), dir.join("plot.png"));
        plot_svg(&svg, "a title", &sample()).unwrap();
        plot_png(&png, "a title", &sample()).unwrap();
        let text = std::fs::read_to_string(&svg).unwrap();
        assert!(text.contains("the contract: 0.5 px") && text.contains("projective"));
        let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&png).unwrap()));
        assert_eq!(decoder.read_info().unwrap().info().size(), SIZE);
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn nothing_to_plot_is_an_error() {
        assert!(matches!(plot_svg(Path::new("unused.svg"), "", &[]), Err(PlotError::Empty)));
        assert!(!Path::new("unused.svg").exists());
    }

    #[test]
    fn ticks_are_one_two_five() {
        let axis = LogAxis { low: 8.0, high: 120.0 };
        let shown: Vec<String> = axis.ticks().iter().map(|t| axis.format_ext(t)).collect();
        assert_eq!(shown, ["10", "20", "50", "100"]);
        assert_eq!(plain(0.05), "0.05");
    }
}
