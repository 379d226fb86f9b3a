//! Block triangular form of a square matrix.

/// Groups the indices of a square matrix with `count` columns such that the matrix is block lower
/// triangular in the order of the groups: entry (i, j) is zero if the group of `i` precedes the
/// group of `j`. `rows` yields the rows of the entries of a column. The groups are the strongly
/// connected components of the graph with an edge from `j` to `i` for each entry (i, j), found by
/// Tarjan's algorithm (1972), so none of them can be split further. The indices of a group are in
/// ascending order.
pub(crate) fn triangular_blocks<I: Iterator<Item = usize>>(
    count: usize,
    rows: impl Fn(usize) -> I,
) -> Vec<Vec<usize>> {
    const NEW: usize = usize::MAX;
    // Order of discovery; smallest order that is reachable from an index.
    let (mut order, mut reachable) = (vec![NEW; count], vec![NEW; count]);
    let mut is_open = vec![false; count];
    let (mut open, mut path) = (Vec::new(), Vec::new());
    let mut groups = Vec::new();
    let mut next = 0;
    for start in 0..count {
        if order[start] != NEW {
            continue;
        }
        let mut entering = Some(start);
        loop {
            if let Some(index) = entering.take() {
                (order[index], reachable[index]) = (next, next);
                next += 1;
                is_open[index] = true;
                open.push(index);
                path.push((index, rows(index)));
            }
            let Some((index, entries)) = path.last_mut() else { break };
            let index = *index;
            if let Some(to) = entries.next() {
                if order[to] == NEW {
                    entering = Some(to);
                } else if is_open[to] {
                    reachable[index] = reachable[index].min(order[to]);
                }
                continue;
            }
            path.pop();
            if let Some((above, _)) = path.last() {
                reachable[*above] = reachable[*above].min(reachable[index]);
            }
            if reachable[index] == order[index] {
                let first = open.iter().rposition(|other| *other == index).unwrap_or(0);
                let mut group = open.split_off(first);
                group.iter().for_each(|member| is_open[*member] = false);
                group.sort_unstable();
                groups.push(group);
            }
        }
    }
    // Groups are complete after all groups that they influence.
    groups.reverse();
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Checks that the groups contain each index once, that the matrix is block triangular, and
        /// that the members of a group influence each other.
        #[test]
        fn groups_are_triangular_and_connected(
            places in prop::collection::vec((0..9usize, 0..9usize), 0..20),
        ) {
            let count = 9;
            let groups = triangular_blocks(count, |column| {
                places.iter().filter(move |(_, own)| *own == column).map(|(row, _)| *row)
            });
            let mut group_of = vec![usize::MAX; count];
            for (k, group) in groups.iter().enumerate() {
                for &member in group {
                    prop_assert_eq!(group_of[member], usize::MAX);
                    group_of[member] = k;
                }
            }
            prop_assert!(group_of.iter().all(|group| *group != usize::MAX));
            prop_assert!(places.iter().all(|&(row, column)| group_of[row] >= group_of[column]));
            let mut reaches = vec![vec![false; count]; count];
            (0..count).for_each(|k| reaches[k][k] = true);
            places.iter().for_each(|&(row, column)| reaches[column][row] = true);
            for via in 0..count {
                for from in 0..count {
                    for to in 0..count {
                        reaches[from][to] |= reaches[from][via] && reaches[via][to];
                    }
                }
            }
            for from in 0..count {
                for to in 0..count {
                    let is_mutual = reaches[from][to] && reaches[to][from];
                    prop_assert_eq!(is_mutual, group_of[from] == group_of[to]);
                }
            }
        }
    }
}
