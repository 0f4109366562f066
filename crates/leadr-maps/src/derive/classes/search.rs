//! All divisions of a few parts into classes.

/// Calls a function with each division of this many parts into classes. A class is the set of its parts, as bits.
pub(super) fn for_each_division(parts: usize, classes: usize, mut visit: impl FnMut(&[usize])) {
    let mut sets = vec![0; classes];
    if (1..=parts).contains(&classes) {
        place(0, parts, 0, &mut sets, &mut visit);
    }
}

/// Places the part `next` and all later ones. The first `used` sets have parts.
fn place(next: usize, parts: usize, used: usize, sets: &mut [usize], visit: &mut impl FnMut(&[usize])) {
    if next == parts {
        visit(sets);
        return;
    }
    // As many parts must remain as there are empty sets.
    let first = if parts - next == sets.len() - used { used } else { 0 };
    for set in first..sets.len().min(used + 1) {
        sets[set] |= 1 << next;
        place(next + 1, parts, used.max(set + 1), sets, visit);
        sets[set] &= !(1 << next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn divisions_are_all_and_different() {
        // Stirling numbers of the second kind.
        for (parts, classes, number) in [(1, 1, 1), (4, 2, 7), (5, 3, 25), (6, 4, 65), (10, 4, 34_105), (3, 4, 0)] {
            let mut found = BTreeSet::new();
            for_each_division(parts, classes, |sets| {
                assert!(sets.iter().all(|set| *set > 0) && sets.iter().sum::<usize>() == (1 << parts) - 1);
                let mut sets = sets.to_vec();
                sets.sort_unstable();
                assert!(found.insert(sets));
            });
            assert_eq!(found.len(), number, "{parts} {classes}");
        }
    }
}
