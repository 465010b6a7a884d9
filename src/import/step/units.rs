//! Units and uncertainty of a representation context (ISO 10303-41 and -43).

use super::args::{Args, Value};
use super::error::StepError;
use super::file::{Entity, File};
use super::kinds::Kind;

/// Measures of measures may not nest deeper.
const MAX_DEPTH: u8 = 8;

/// What the numbers of a context mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// Millimetres in its unit of length.
    pub length: f64,
    /// Radians in its unit of angle.
    pub angle: f64,
    /// The file's uncertainty in millimetres.
    pub tolerance: f64,
}

impl Default for Units {
    /// Millimetres, radians, and a micrometre of uncertainty.
    fn default() -> Self {
        Self { length: 1.0, angle: 1.0, tolerance: 1e-3 }
    }
}

/// Metres, or radians, in the unit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unit {
    Length(f64),
    Angle(f64),
    Other,
}

impl Units {
    /// The units of context `id`, and what was wrong with them.
    pub fn of_context(file: &File, id: u32) -> (Self, Vec<StepError>) {
        let mut units = Self::default();
        let mut errors = Vec::new();
        let Ok(context) = file.get(id) else { return (units, vec![StepError::Missing(id)]) };
        let mut has_length = false;
        let assigned = part(&context, Kind::GlobalUnitAssignedContext).and_then(|mut a| a.references().ok());
        for unit in assigned.unwrap_or_default() {
            match unit_of(file, unit, 0) {
                Ok(Unit::Length(metres)) => {
                    units.length = 1000.0 * metres;
                    has_length = true;
                }
                Ok(Unit::Angle(radians)) => units.angle = radians,
                Ok(Unit::Other) => {}
                Err(error) => errors.push(error),
            }
        }
        if !has_length {
            let what = "there is no unit of length: millimetres are assumed".into();
            errors.push(StepError::Bad { entity: id, what });
        }
        let measures = part(&context, Kind::GlobalUncertaintyAssignedContext).and_then(|mut a| a.references().ok());
        let lengths = measures.unwrap_or_default().into_iter().filter_map(|m| match measure(file, m, 0) {
            Ok(Unit::Length(metres)) => Some(1000.0 * metres),
            _ => None,
        });
        // Zero or a kilometre is nobody's uncertainty.
        let sensible = |t: &f64| (1e-9..=10.0).contains(t);
        if let Some(tolerance) = lengths.filter(sensible).reduce(f64::max) {
            units.tolerance = tolerance;
        }
        (units, errors)
    }
}

/// The parameters of `kind`, which stands alone (behind two of its supertype) or in a complex entity.
fn part<'a>(context: &Entity<'a>, kind: Kind) -> Option<Args<'a>> {
    if context.kind == kind { context.args().ok().map(|a| a.skip(2)) } else { context.part(kind) }
}

fn unit_of(file: &File, id: u32, depth: u8) -> Result<Unit, StepError> {
    if depth > MAX_DEPTH {
        return Err(StepError::Depth(id));
    }
    let entity = file.get(id)?;
    if entity.kind == Kind::SiUnit {
        return si_unit(entity.args()?.skip(1));
    }
    let parts = entity.parts();
    let of = |kind| parts.iter().find(|(k, _)| *k == kind).map(|(_, args)| args.clone());
    if let Some(args) = of(Kind::SiUnit) {
        return si_unit(args);
    }
    let conversion = of(Kind::ConversionBasedUnit);
    let Some(args) = conversion else { return Ok(Unit::Other) };
    let factor = args.skip(1).reference()?;
    match measure(file, factor, depth + 1)? {
        Unit::Other if of(Kind::LengthUnit).is_some() || of(Kind::PlaneAngleUnit).is_some() => {
            Err(StepError::Parameter { entity: id, index: 2, expected: "a measure of length or angle" })
        }
        unit => Ok(unit),
    }
}

/// `(prefix, name)`
fn si_unit(mut args: Args) -> Result<Unit, StepError> {
    let prefix = match args.next() {
        Some(Value::Enumeration(name)) => prefix(name),
        _ => 1.0,
    };
    Ok(match args.enumeration() {
        b"METRE" => Unit::Length(prefix),
        b"RADIAN" => Unit::Angle(prefix),
        _ => Unit::Other,
    })
}

/// A measure with its unit.
fn measure(file: &File, id: u32, depth: u8) -> Result<Unit, StepError> {
    let entity = file.get(id)?;
    let mut args = match entity.kind {
        Kind::Complex => entity.part(Kind::MeasureWithUnit).ok_or_else(|| entity.is_not("a measure"))?,
        _ => entity.args()?,
    };
    let value = args.number()?;
    if value <= 0.0 {
        return Err(StepError::Parameter { entity: id, index: 1, expected: "a positive measure" });
    }
    Ok(match unit_of(file, args.reference()?, depth + 1)? {
        Unit::Length(metres) => Unit::Length(value * metres),
        Unit::Angle(radians) => Unit::Angle(value * radians),
        Unit::Other => Unit::Other,
    })
}

fn prefix(name: &[u8]) -> f64 {
    match name {
        b"EXA" => 1e18,
        b"PETA" => 1e15,
        b"TERA" => 1e12,
        b"GIGA" => 1e9,
        b"MEGA" => 1e6,
        b"KILO" => 1e3,
        b"HECTO" => 1e2,
        b"DECA" => 1e1,
        b"DECI" => 1e-1,
        b"CENTI" => 1e-2,
        b"MILLI" => 1e-3,
        b"MICRO" => 1e-6,
        b"NANO" => 1e-9,
        b"PICO" => 1e-12,
        b"FEMTO" => 1e-15,
        b"ATTO" => 1e-18,
        _ => 1.0,
    }
}
