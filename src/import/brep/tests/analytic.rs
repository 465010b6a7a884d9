//! Faces on planes, cylinders, cones, spheres and tori.

use super::*;

/// Edges through corner points.
fn polygon(points: &[DVec3]) -> Vec<EdgeUse> {
    (0..points.len()).map(|k| edge(10 + k as u32, line(points[k], points[(k + 1) % points.len()]))).collect()
}

#[test]
fn plane_with_a_round_hole() {
    let frame = skew();
    let outer = polygon(&[(0.0, 0.0), (4.0, 0.5), (3.0, 3.0), (-1.0, 2.5)].map(|(x, y)| frame.point(x, y, 0.0)));
    let hole = circle(Frame { origin: frame.point(1.5, 1.5, 0.0), ..frame }, 0.5, [TAU, 0.0]);
    let built = check(&face(SurfaceForm::Plane(frame), vec![outer, vec![edge(20, hole)]]), 10.5 - PI * 0.25);
    assert_eq!(built.face.loops.len(), 2);
}

#[test]
fn rectangle_along_the_axes_has_no_trim() {
    let frame = skew();
    let outer = polygon(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)].map(|(x, y)| frame.point(x, y, 0.0)));
    let built = check(&face(SurfaceForm::Plane(frame), vec![outer]), 12.0);
    assert!(built.face.loops.is_empty(), "{:?}", built.face.loops);
    assert_eq!(built.face.surface.patches.len(), 1);
}

#[test]
fn cylinder_with_a_seam_edge_and_without() {
    let frame = skew();
    let surface = SurfaceForm::Cylinder { frame, radius: 2.0 };
    let bottom = edge(1, circle(frame, 2.0, [0.0, TAU]));
    let top = edge(2, circle(raised(frame, 3.0), 2.0, [0.0, TAU]));
    let seam = edge(3, line(frame.point(2.0, 0.0, 0.0), frame.point(2.0, 0.0, 3.0)));
    let with_seam = vec![vec![bottom.clone(), seam.clone(), back(&top), back(&seam)]];
    let built = check(&face(surface.clone(), with_seam), TAU * 6.0);
    assert!(built.face.loops.is_empty(), "{:?}", built.face.loops);
    let top = edge(2, circle(raised(frame, 3.0), 2.0, [1.0 + TAU, 1.0]));
    check(&face(surface.clone(), vec![vec![bottom.clone()], vec![top.clone()]]), TAU * 6.0);
    // Both wound the wrong way.
    check(&face(surface, vec![vec![back(&top)], vec![back(&bottom)]]), TAU * 6.0);
}

#[test]
fn cylinder_cut_by_a_slanted_plane() {
    let frame = skew();
    let surface = SurfaceForm::Cylinder { frame, radius: 2.0 };
    let bottom = edge(1, circle(frame, 2.0, [0.0, TAU]));
    // The ellipse z = 3 + x / 2.
    let slanted = Frame::new(frame.point(0.0, 0.0, 3.0), frame.z - frame.x * 0.5, frame.x).unwrap();
    let span = |range| CurveSpan { curve: CurveForm::Ellipse { frame: slanted, radii: [5f64.sqrt(), 2.0] }, range };
    check(&face(surface.clone(), vec![vec![bottom.clone()], vec![edge(2, span([TAU, 0.0]))]]), TAU * 6.0);
    check(&face(surface, vec![vec![bottom], vec![edge(2, span([0.5 + TAU, 0.5]))]]), TAU * 6.0);
}

#[test]
fn cone_to_its_apex() {
    let frame = skew();
    let (radius, half_angle) = (2.0, 0.4f64);
    let surface = SurfaceForm::Cone { frame, radius, half_angle };
    let base = edge(1, circle(frame, radius, [0.0, TAU]));
    let apex = frame.point(0.0, 0.0, -radius / half_angle.tan());
    let area = PI * radius * radius / half_angle.sin();
    // The material is below the base, hence to the left of its reverse.
    let mut source = face(surface.clone(), vec![vec![back(&base)]]);
    source.bounds.push(Bound::Vertex(apex));
    check(&source, area);
    let seam = edge(2, line(frame.point(radius, 0.0, 0.0), apex));
    check(&face(surface.clone(), vec![vec![back(&base), seam.clone(), back(&seam)]]), area);
    check(&face(surface, vec![vec![seam.clone(), back(&seam), back(&base)]]), area);
}

#[test]
fn spheres_whole_capped_and_pierced() {
    let frame = skew();
    let surface = SurfaceForm::Sphere { frame, radius: 2.0 };
    let whole = 16.0 * PI;
    let mut source = face(surface.clone(), vec![]);
    check(&source, whole);
    source.bounds = vec![Bound::Vertex(frame.point(0.0, 0.0, 2.0))];
    check(&source, whole);
    // A cap about the pole, each side of its circle.
    let h: f64 = 0.7;
    let cap = edge(1, circle(raised(frame, 2.0 - h), (h * (4.0 - h)).sqrt(), [0.3, TAU + 0.3]));
    check(&face(surface.clone(), vec![vec![cap.clone()]]), TAU * 2.0 * h);
    check(&face(surface.clone(), vec![vec![back(&cap)]]), whole - TAU * 2.0 * h);
    // Away from the poles: the circle's own side decides.
    let aside = Frame::new(frame.origin, frame.x - frame.y * 2.0 + frame.z * 0.3, frame.z).unwrap();
    let cap = edge(1, circle(raised(aside, 2.0 - h), (h * (4.0 - h)).sqrt(), [0.0, TAU]));
    check(&face(surface.clone(), vec![vec![cap.clone()]]), TAU * 2.0 * h);
    check(&face(surface.clone(), vec![vec![back(&cap)]]), whole - TAU * 2.0 * h);
    // Two antipodal holes.
    let other = Frame::new(frame.origin, -aside.z, frame.z).unwrap();
    let cap2 = edge(2, circle(raised(other, 2.0 - h), (h * (4.0 - h)).sqrt(), [0.0, TAU]));
    check(&face(surface.clone(), vec![vec![back(&cap)], vec![back(&cap2)]]), whole - 2.0 * TAU * 2.0 * h);
}

#[test]
fn sphere_through_its_poles() {
    let frame = skew();
    let surface = SurfaceForm::Sphere { frame, radius: 2.0 };
    // A lune between two meridians, from pole to pole and back.
    let meridian = |u: f64| Frame {
        origin: frame.origin,
        x: frame.x * u.cos() + frame.y * u.sin(),
        y: frame.z,
        z: frame.y * -u.cos() + frame.x * u.sin(),
    };
    let lune = |a: f64, b: f64| {
        vec![
            edge(1, circle(meridian(b), 2.0, [-PI / 2.0, PI / 2.0])),
            edge(2, circle(meridian(a), 2.0, [PI / 2.0, -PI / 2.0])),
        ]
    };
    check(&face(surface.clone(), vec![lune(0.2, 1.3)]), 1.1 * 8.0);
    check(&face(surface.clone(), vec![lune(2.0, 7.0)]), 5.0 * 8.0);
    // One great circle through both poles as one edge: half of the sphere.
    check(&face(surface.clone(), vec![vec![edge(1, circle(meridian(0.4), 2.0, [0.0, TAU]))]]), 8.0 * PI);
    // Hemisphere: equator, seam to the pole and back.
    let equator = edge(1, circle(frame, 2.0, [0.0, TAU]));
    let seam = edge(2, circle(meridian(0.0), 2.0, [0.0, PI / 2.0]));
    check(&face(surface.clone(), vec![vec![equator.clone(), seam.clone(), back(&seam)]]), 8.0 * PI);
    check(&face(surface, vec![vec![back(&seam), equator, seam]]), 8.0 * PI);
}

#[test]
fn octant_of_a_sphere_off_its_axes() {
    let frame = skew();
    let surface = SurfaceForm::Sphere { frame, radius: 2.0 };
    let turned = Frame::new(frame.origin, DVec3::new(0.1, 0.9, 0.3), DVec3::X).unwrap();
    let (x, y, z) = (turned.x, turned.y, turned.z);
    let quarter =
        |a: DVec3, b: DVec3| circle(Frame { origin: frame.origin, x: a, y: b, z: a.cross(b) }, 2.0, [0.0, PI / 2.0]);
    let bound = vec![edge(1, quarter(x, y)), edge(2, quarter(y, z)), edge(3, quarter(z, x))];
    check(&face(surface, vec![bound]), 2.0 * PI);
}

/// Area of the torus' part over tube angles `v` and a whole turn.
fn torus_band(major: f64, minor: f64, v: [f64; 2]) -> f64 {
    TAU * minor * (major * (v[1] - v[0]) + minor * (v[1].sin() - v[0].sin()))
}

#[test]
fn torus_pieces() {
    let frame = skew();
    let (major, minor) = (3.0, 1.0);
    let surface = SurfaceForm::Torus { frame, major, minor };
    check(&face(surface.clone(), vec![]), torus_band(major, minor, [0.0, TAU]));
    let ring = |number: u32, v: f64, range: [f64; 2]| {
        edge(number, circle(raised(frame, minor * v.sin()), major + minor * v.cos(), range))
    };
    let tube = |u: f64, range: [f64; 2]| {
        let out = frame.x * u.cos() + frame.y * u.sin();
        circle(Frame { origin: frame.origin + out * major, x: out, y: frame.z, z: out.cross(frame.z) }, minor, range)
    };
    // A band on the inside, across no seam, then the rest.
    let (a, b) = (2.0, 4.0);
    let band = torus_band(major, minor, [a, b]);
    check(&face(surface.clone(), vec![vec![ring(1, a, [0.0, TAU])], vec![ring(2, b, [TAU, 0.0])]]), band);
    let rest = torus_band(major, minor, [0.0, TAU]) - band;
    check(&face(surface.clone(), vec![vec![ring(1, b, [0.0, TAU])], vec![ring(2, a, [TAU, 0.0])]]), rest);
    // A piece of the tube between two of its circles.
    let (u0, u1) = (5.0, 8.0);
    let pipe = vec![vec![edge(1, tube(u0, [TAU, 0.0]))], vec![edge(2, tube(u1, [1.0, 1.0 + TAU]))]];
    check(&face(surface.clone(), pipe), (u1 - u0) * TAU * major * minor);
    // Four arcs across both seams.
    let patch = vec![vec![
        ring(1, -0.5, [-0.7, 0.9]),
        edge(2, tube(0.9, [-0.5, 0.8])),
        ring(3, 0.8, [0.9, -0.7]),
        edge(4, tube(-0.7, [0.8, -0.5])),
    ]];
    let built = check(&face(surface.clone(), patch), torus_band(major, minor, [-0.5, 0.8]) * 1.6 / TAU);
    assert!(built.face.loops.is_empty());
    // Cut open along both seams: all of it.
    let open = vec![vec![
        ring(1, 0.0, [0.0, TAU]),
        edge(2, tube(0.0, [0.0, TAU])),
        ring(1, 0.0, [TAU, 0.0]),
        edge(2, tube(0.0, [TAU, 0.0])),
    ]];
    check(&face(surface, open), torus_band(major, minor, [0.0, TAU]));
}
