//! The cases: a title, and the arguments that `render` or `verify` would take.

/// Title and command line.
pub const CASES: &[(&str, &str)] = &[
    ("eye inside a sphere", "builtin:sphere --eye 0.1,0.05,0.02 --target 1,0.3,0.2"),
    ("eye in the tube of a torus", "builtin:torus --eye 1,0.02,0.01 --target 1,1,0.1"),
    ("eye at a pole", "builtin:sphere --eye 0,0,1 --target 0.3,0.2,0"),
    ("sphere, zoom 1000 at the silhouette", "builtin:sphere --zoom 1000 --target 0,0.999,0"),
    ("sphere, 1/100 px", "builtin:sphere --zoom 0.00002"),
    ("torus, 100,000 screens", "builtin:torus --zoom 100000 --target 1,0,0.25"),
];
