//! Pairwise covering sets: few combinations that hold every pair of choices of two factors.

/// Combinations of levels, one a factor, in which all pairs of levels of two factors occur. `levels`: of each factor.
pub fn pairwise<const N: usize>(levels: [usize; N]) -> Vec<[usize; N]> {
    let mut missing = Vec::new();
    for (a, b) in (0..N).flat_map(|b| (0..b).map(move |a| (a, b))) {
        missing.extend((0..levels[a]).flat_map(|i| (0..levels[b]).map(move |j| [(a, i), (b, j)])));
    }
    let mut all = Vec::new();
    while let Some(&[(a, i), (b, j)]) = missing.first() {
        let mut chosen = [None; N];
        (chosen[a], chosen[b]) = (Some(i), Some(j));
        for factor in 0..N {
            if chosen[factor].is_none() {
                chosen[factor] = best(&missing, &chosen, factor, levels[factor], all.len());
            }
        }
        let combination = chosen.map(Option::unwrap_or_default);
        missing.retain(|pair| !pair.iter().all(|&(factor, level)| combination[factor] == level));
        all.push(combination);
    }
    all
}

/// The level that completes the most missing pairs with what is chosen; among equals by turns.
fn best(
    missing: &[[(usize, usize); 2]],
    chosen: &[Option<usize>],
    factor: usize,
    levels: usize,
    turn: usize,
) -> Option<usize> {
    let gain = |level: usize| {
        let completes = |pair: &&[(usize, usize); 2]| {
            let [first, second] = **pair;
            let fits = |own: (usize, usize), other: (usize, usize)| {
                own == (factor, level) && chosen[other.0].is_none_or(|chosen| chosen == other.1)
            };
            fits(first, second) || fits(second, first)
        };
        missing.iter().filter(completes).count()
    };
    (0..levels).map(|k| (k + turn) % levels).max_by_key(|&level| gain(level))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_occurs_and_few_combinations_do() {
        for levels in [[12, 5, 7, 2, 2], [1, 5, 7, 2, 2], [3, 3, 3, 3, 3]] {
            let all = pairwise(levels);
            for (a, b) in (0..5).flat_map(|b| (0..b).map(move |a| (a, b))) {
                for (i, j) in (0..levels[a]).flat_map(|i| (0..levels[b]).map(move |j| (i, j))) {
                    assert!(all.iter().any(|c| c[a] == i && c[b] == j), "{levels:?}: {a} {i}, {b} {j}");
                }
            }
            let mut largest = levels;
            largest.sort_unstable();
            let least = largest[4] * largest[3];
            assert!(all.len() >= least && all.len() <= least * 3 / 2 + 4, "{levels:?}: {}", all.len());
        }
    }
}
