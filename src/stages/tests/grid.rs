//! The grid solver against every smaller grid.

use super::Random;
use crate::stages::bounds::Constraints;
use crate::stages::estimate::solve;

type Constraint = [f64; 3];

fn holds(constraints: &[Constraint], [nu, nv]: [u32; 2], slack: f64) -> bool {
    let (nu, nv) = (f64::from(nu), f64::from(nv));
    constraints.iter().all(|[a, b, c]| a / (nu * nu) + b / (nu * nv) + c / (nv * nv) <= 1.0 + slack)
}

/// Terms of which some are zero, over five orders of magnitude; some squares, so that whole numbers are hit exactly.
fn constraint(random: &mut Random) -> Constraint {
    [(); 3].map(|()| match random.below(4) {
        0 => 0.0,
        1 => (random.below(12) as f64).powi(2),
        _ => 10f64.powf(random.between(-2.5, 2.5)),
    })
}

#[test]
fn no_smaller_grid_satisfies_all_constraints() {
    let mut random = Random(7);
    for _ in 0..3000 {
        let mut constraints = Constraints::new();
        for diagonal in 0..2 {
            (0..random.below(6)).for_each(|_| constraints.push(diagonal, constraint(&mut random)));
        }
        let grid = solve(&constraints).expect("small constraints have a grid");
        let [nu, nv] = grid.quads;
        assert!(holds(constraints.of(grid.diagonal.into()), grid.quads, 1e-9), "{grid:?} for {constraints:?}");
        for u in 1..nu * nv {
            // The largest v that still makes a smaller grid: constraints only relax as v grows.
            let v = (nu * nv - 1) / u;
            let smaller = |diagonal| holds(constraints.of(diagonal), [u, v], -1e-9);
            assert!(!smaller(0) && !smaller(1), "{grid:?}, but {u} x {v} does for {constraints:?}");
        }
    }
}

#[test]
fn grids_beyond_the_limit_are_refused_and_not_cut() {
    for huge in [1e9, 1e300, f64::INFINITY] {
        for at in 0..3 {
            let mut constraints = Constraints::new();
            let mut one = [1.0; 3];
            one[at] = huge;
            (0..2).for_each(|diagonal| constraints.push(diagonal, one));
            let grid = solve(&constraints);
            let kept = grid.is_none_or(|g| holds(constraints.of(g.diagonal.into()), g.quads, 1e-9));
            assert!(kept, "{grid:?} for {huge} in term {at}");
        }
    }
}
