//! Groups of connected items.

/// Disjoint sets of the items `0..count` (Galler and Fischer 1964). The least item of a set
/// represents it.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    /// An item of the same set with a smaller index; the item itself if it is the least one.
    parents: Vec<usize>,
}

impl DisjointSets {
    /// Creates a set for each item.
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// Returns the least item of the set of an item.
    pub fn least(&mut self, mut item: usize) -> usize {
        while self.parents[item] != item {
            self.parents[item] = self.parents[self.parents[item]];
            item = self.parents[item];
        }
        item
    }

    /// Unites the sets of two items. Returns false if the items belonged to the same set already.
    pub fn unite(&mut self, one: usize, other: usize) -> bool {
        let (one, other) = (self.least(one), self.least(other));
        self.parents[one.max(other)] = one.min(other);
        one != other
    }
}
