//! Small STEP files, put together.
#![allow(dead_code)] // each test file uses its own part

use std::fmt::Display;

/// The text of a DATA section; `add` gives each entity its number.
#[derive(Clone)]
pub struct Text {
    lines: Vec<String>,
    first: u32,
}

/// Unit of length, of angle: SI prefixes, or a conversion.
#[derive(Clone, Copy)]
pub enum Units {
    Millimetres,
    Metres,
    InchesAndDegrees,
}

pub fn list(ids: &[u32]) -> String {
    let ids: Vec<String> = ids.iter().map(|id| format!("#{id}")).collect();
    format!("({})", ids.join(","))
}

impl Default for Text {
    fn default() -> Self {
        Self { lines: Vec::new(), first: 10 }
    }
}

impl Text {
    /// A box that two mapped items show, in its place and moved by 5 in x: the items.
    pub fn two_places(&mut self) -> [u32; 2] {
        let context = self.context(Units::Millimetres);
        let solid = self.box_solid([0.0; 3], [1.0; 3]);
        let part = self.representation(&[solid], context);
        let [origin, place] = [self.at([0.0; 3]), self.at([5.0, 0.0, 0.0])];
        let items = [self.mapped(part, origin, origin), self.mapped(part, origin, place)];
        self.representation(&items, context);
        items
    }

    /// A box as a solid of its own: its faces, its solid, its representation.
    pub fn solid_of_faces(&mut self) -> (Vec<u32>, u32, u32) {
        let context = self.context(Units::Millimetres);
        let faces = self.box_faces([0.0; 3], [1.0; 3]).to_vec();
        let shell = self.add(format_args!("CLOSED_SHELL('',{})", list(&faces)));
        let solid = self.add(format_args!("MANIFOLD_SOLID_BREP('',#{shell})"));
        let shape = self.representation(&[solid], context);
        (faces, solid, shape)
    }

    pub fn add(&mut self, entity: impl Display) -> u32 {
        let id = self.next();
        self.lines.push(format!("#{id}={entity};\n"));
        id
    }

    /// The number that the next entity gets.
    pub fn next(&self) -> u32 {
        self.first + self.lines.len() as u32
    }

    pub fn lines(&self) -> &[String] {
        &self.lines
    }

    pub fn point(&mut self, [x, y, z]: [f64; 3]) -> u32 {
        self.add(format_args!("CARTESIAN_POINT('',({x:?},{y:?},{z:?}))"))
    }

    pub fn direction(&mut self, [x, y, z]: [f64; 3]) -> u32 {
        self.add(format_args!("DIRECTION('',({x:?},{y:?},{z:?}))"))
    }

    pub fn placement(&mut self, origin: [f64; 3], z: [f64; 3], x: [f64; 3]) -> u32 {
        let [origin, z, x] = [self.point(origin), self.direction(z), self.direction(x)];
        self.add(format_args!("AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})"))
    }

    /// A placement at a point, not turned.
    pub fn at(&mut self, origin: [f64; 3]) -> u32 {
        self.placement(origin, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    }

    pub fn context(&mut self, units: Units) -> u32 {
        let si = |prefix: &str| format!("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({prefix},.METRE.))");
        let radian = self.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))");
        let (length, angle) = match units {
            Units::Millimetres => (self.add(si(".MILLI.")), radian),
            Units::Metres => (self.add(si("$")), radian),
            Units::InchesAndDegrees => {
                let millimetre = self.add(si(".MILLI."));
                let inch = self.add(format_args!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#{millimetre})"));
                let degree = self.add(format_args!(
                    "PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.0174532925199433),#{radian})"
                ));
                let inch =
                    self.add(format_args!("(CONVERSION_BASED_UNIT('INCH',#{inch}) LENGTH_UNIT() NAMED_UNIT($))"));
                let degree = self
                    .add(format_args!("(CONVERSION_BASED_UNIT('DEGREE',#{degree}) NAMED_UNIT($) PLANE_ANGLE_UNIT())"));
                (inch, degree)
            }
        };
        let uncertainty = self.add(format_args!(
            "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-06),#{length},'distance_accuracy_value','')"
        ));
        self.add(format_args!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{uncertainty})) \
             GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle})) REPRESENTATION_CONTEXT('',''))"
        ))
    }

    fn edge(&mut self, points: [[f64; 3]; 2], vertices: [u32; 2]) -> u32 {
        let direction = [0, 1, 2].map(|k| points[1][k] - points[0][k]);
        let [point, direction] = [self.point(points[0]), self.direction(direction)];
        let vector = self.add(format_args!("VECTOR('',#{direction},1.)"));
        let line = self.add(format_args!("LINE('',#{point},#{vector})"));
        self.add(format_args!("EDGE_CURVE('',#{},#{},#{line},.T.)", vertices[0], vertices[1]))
    }

    /// The faces of a box, with normals outward.
    pub fn box_faces(&mut self, low: [f64; 3], high: [f64; 3]) -> Vec<u32> {
        let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
        let vertices: Vec<u32> = (0..8)
            .map(|k| {
                let point = self.point(corner(k));
                self.add(format_args!("VERTEX_POINT('',#{point})"))
            })
            .collect();
        let mut edges = Vec::new();
        for (k, axis) in (0..8).flat_map(|k| (0..3).map(move |axis| (k, axis))) {
            if k >> axis & 1 == 0 {
                let end = k | 1 << axis;
                edges.push(([k, end], self.edge([corner(k), corner(end)], [vertices[k], vertices[end]])));
            }
        }
        let mut faces = Vec::new();
        for (axis, side) in (0..3).flat_map(|axis| [0, 1].map(|side| (axis, side))) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let base = side << axis;
            let mut ring = [base, base | 1 << u, base | 1 << u | 1 << v, base | 1 << v];
            if side == 0 {
                ring.reverse();
            }
            let mut loop_edges = Vec::new();
            for k in 0..4 {
                let (a, b) = (ring[k], ring[(k + 1) % 4]);
                let (ends, edge) = edges.iter().find(|(e, _)| e.contains(&a) && e.contains(&b)).copied().unwrap();
                let sense = if ends == [a, b] { "T" } else { "F" };
                loop_edges.push(self.add(format_args!("ORIENTED_EDGE('',*,*,#{edge},.{sense}.)")));
            }
            let edge_loop = self.add(format_args!("EDGE_LOOP('',{})", list(&loop_edges)));
            let bound = self.add(format_args!("FACE_OUTER_BOUND('',#{edge_loop},.T.)"));
            let mut normal = [0.0; 3];
            normal[axis] = 1.0;
            let mut x = [0.0; 3];
            x[u] = 1.0;
            let placement = self.placement(corner(base), normal, x);
            let plane = self.add(format_args!("PLANE('',#{placement})"));
            // Planes all look along their axis: half of the faces are against them.
            let sense = if side == 1 { "T" } else { "F" };
            faces.push(self.add(format_args!("ADVANCED_FACE('face {axis} {side}',(#{bound}),#{plane},.{sense}.)")));
        }
        faces
    }

    pub fn box_shell(&mut self, low: [f64; 3], high: [f64; 3]) -> u32 {
        let faces = self.box_faces(low, high);
        self.add(format_args!("CLOSED_SHELL('',{})", list(&faces)))
    }

    pub fn box_solid(&mut self, low: [f64; 3], high: [f64; 3]) -> u32 {
        let shell = self.box_shell(low, high);
        self.add(format_args!("MANIFOLD_SOLID_BREP('a box',#{shell})"))
    }

    pub fn representation(&mut self, items: &[u32], context: u32) -> u32 {
        self.add(format_args!("SHAPE_REPRESENTATION('',{},#{context})", list(items)))
    }

    /// A product with its shape; the product definition.
    pub fn product(&mut self, name: &str, shape: u32) -> u32 {
        let product = self.add(format_args!("PRODUCT('id of {name}','{name}','',())"));
        let formation = self.add(format_args!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
        let definition = self.add(format_args!("PRODUCT_DEFINITION('','',#{formation},$)"));
        let shape_of = self.add(format_args!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"));
        self.add(format_args!("SHAPE_DEFINITION_REPRESENTATION(#{shape_of},#{shape})"));
        definition
    }

    /// One product in another, each with its shape; the relationship goes from the child's shape to the parent's, or
    /// the other way. Returns the numbers of the usage, its shape, the relationship, and what joins these two.
    pub fn usage(
        &mut self,
        name: &str,
        [parent, child]: [(u32, u32); 2],
        operator: u32,
        parent_first: bool,
    ) -> [u32; 4] {
        let [from, to] = if parent_first { [parent.1, child.1] } else { [child.1, parent.1] };
        let usage =
            self.add(format_args!("NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','{name}','',#{},#{},$)", parent.0, child.0));
        let place = self.add(format_args!("PRODUCT_DEFINITION_SHAPE('','',#{usage})"));
        let relation = self.add(format_args!(
            "(REPRESENTATION_RELATIONSHIP('','',#{},#{}) REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{operator}) \
             SHAPE_REPRESENTATION_RELATIONSHIP())",
            from, to
        ));
        let dependent = self.add(format_args!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{place})"));
        [usage, place, relation, dependent]
    }

    pub fn mapped(&mut self, representation: u32, origin: u32, target: u32) -> u32 {
        let map = self.add(format_args!("REPRESENTATION_MAP(#{origin},#{representation})"));
        self.add(format_args!("MAPPED_ITEM('',#{map},#{target})"))
    }

    /// A style of this colour on an item.
    pub fn style(&mut self, [r, g, b]: [f64; 3], item: u32) -> u32 {
        let color = self.add(format_args!("COLOUR_RGB('',{r:?},{g:?},{b:?})"));
        self.style_of(color, item)
    }

    pub fn style_of(&mut self, color: u32, item: u32) -> u32 {
        let assigned = self.assigned(color);
        self.add(format_args!("STYLED_ITEM('',(#{assigned}),#{item})"))
    }

    /// A style of the colour of this name on an item where `contexts` are passed; it overrides `style`.
    pub fn style_in(&mut self, name: &str, item: u32, style: u32, contexts: &[u32]) {
        let color = self.add(format_args!("DRAUGHTING_PRE_DEFINED_COLOUR('{name}')"));
        let (assigned, contexts) = (self.assigned(color), list(contexts));
        self.add(format_args!(
            "CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#{assigned}),#{item},#{style},{contexts})"
        ));
    }

    /// The assignment of a colour to surfaces.
    fn assigned(&mut self, color: u32) -> u32 {
        let fill = self.add(format_args!("FILL_AREA_STYLE_COLOUR('',#{color})"));
        let area = self.add(format_args!("FILL_AREA_STYLE('',(#{fill}))"));
        let surface = self.add(format_args!("SURFACE_STYLE_FILL_AREA(#{area})"));
        let side = self.add(format_args!("SURFACE_SIDE_STYLE('',(#{surface}))"));
        let usage = self.add(format_args!("SURFACE_STYLE_USAGE(.BOTH.,#{side})"));
        self.add(format_args!("PRESENTATION_STYLE_ASSIGNMENT((#{usage}))"))
    }

    /// The whole file.
    pub fn file(&self) -> String {
        file(&self.lines.concat())
    }
}

/// A file with this DATA section.
pub fn file(data: &str) -> String {
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('a','',(''),(''),'','','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{data}ENDSEC;\nEND-ISO-10303-21;\n"
    )
}

/// A box in millimetres, with a representation.
pub fn one_box() -> Text {
    let mut text = Text::default();
    let context = text.context(Units::Millimetres);
    let solid = text.box_solid([0.0; 3], [1.0, 2.0, 3.0]);
    text.representation(&[solid], context);
    text
}

/// Something of most kinds: an assembly of a coloured box with a void, curved surfaces, splines.
pub fn mixture() -> Text {
    let mut text = Text::default();
    let context = text.context(Units::InchesAndDegrees);
    let [outer, inner] = [text.box_shell([0.0; 3], [4.0; 3]), text.box_shell([1.0; 3], [2.0; 3])];
    let inner = text.add(format_args!("ORIENTED_CLOSED_SHELL('',*,#{inner},.F.)"));
    let solid = text.add(format_args!("BREP_WITH_VOIDS('',#{outer},(#{inner}))"));
    text.style([0.8, 0.1, 0.1], solid);
    let origin = text.at([0.0; 3]);
    let hollow = text.representation(&[origin, solid], context);
    let surfaces = surfaces(&mut text);
    let set = text.add(format_args!("GEOMETRIC_SET('',{})", list(&surfaces)));
    let top = text.representation(&[origin, set], context);
    let [top_product, hollow_product] = [text.product("top", top), text.product("hollow", hollow)];
    let place = text.placement([9.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let item = text.add(format_args!("ITEM_DEFINED_TRANSFORMATION('','',#{origin},#{place})"));
    text.usage("one", [(top_product, top), (hollow_product, hollow)], item, false);
    text
}

/// Bare surfaces: a ball, a piece of a cone, a swept arc, a rational B-spline.
fn surfaces(text: &mut Text) -> Vec<u32> {
    let origin = text.at([0.0, 9.0, 0.0]);
    let sphere = text.add(format_args!("SPHERICAL_SURFACE('',#{origin},2.)"));
    let cone = text.add(format_args!("CONICAL_SURFACE('',#{origin},1.,30.)"));
    let circle = text.add(format_args!("CIRCLE('',#{origin},1.5)"));
    let [up, point] = [text.direction([0.0, 0.0, 1.0]), text.point([1.5, 9.0, 0.0])];
    let vector = text.add(format_args!("VECTOR('',#{up},1.)"));
    let arc = text.add(format_args!(
        "TRIMMED_CURVE('',#{circle},(#{point},PARAMETER_VALUE(0.)),(PARAMETER_VALUE(120.)),.T.,.PARAMETER.)"
    ));
    let swept = text.add(format_args!("SURFACE_OF_LINEAR_EXTRUSION('',#{arc},#{vector})"));
    let points: Vec<u32> = (0..4).map(|k| text.point([f64::from(k / 2), f64::from(k % 2), f64::from(k)])).collect();
    let spline = text.add(format_args!(
        "(BOUNDED_SURFACE() B_SPLINE_SURFACE(1,1,({},{}),.UNSPECIFIED.,.F.,.F.,.F.) \
         B_SPLINE_SURFACE_WITH_KNOTS((2,2),(2,2),(0.,1.),(0.,1.),.UNSPECIFIED.) GEOMETRIC_REPRESENTATION_ITEM() \
         RATIONAL_B_SPLINE_SURFACE(((1.,2.),(1.,1.))) REPRESENTATION_ITEM('patch') SURFACE())",
        list(&points[..2]),
        list(&points[2..])
    ));
    let mut trimmed = |basis: u32, [a, b, c, d]: [f64; 4]| {
        text.add(format_args!("RECTANGULAR_TRIMMED_SURFACE('',#{basis},{a:?},{b:?},{c:?},{d:?},.T.,.T.)"))
    };
    let [sphere, cone, swept] = [
        trimmed(sphere, [0.0, 360.0, -90.0, 90.0]),
        trimmed(cone, [0.0, 180.0, 0.0, 2.0]),
        trimmed(swept, [0.0, 120.0, 0.0, 3.0]),
    ];
    vec![sphere, cone, swept, spline]
}
