//! Which rows of a list belong to each node, so that sums over them have a fixed order.

/// For each node the rows of a list that are its own, in order.
#[derive(Clone, Debug, Default)]
pub struct Incidence {
    /// First entry of each node, then their number.
    pub starts: Vec<u32>,
    /// The rows, node after node.
    pub entries: Vec<u32>,
}

impl Incidence {
    /// For the node of each row in turn.
    #[must_use]
    pub fn new(ids: impl Iterator<Item = u32> + Clone, nodes: usize) -> Self {
        let mut starts = vec![0u32; nodes + 1];
        let mut rows = 0;
        for node in ids.clone() {
            starts[node as usize + 1] += 1;
            rows += 1;
        }
        for n in 0..nodes {
            starts[n + 1] += starts[n];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; rows];
        for (row, node) in ids.enumerate() {
            entries[next[node as usize] as usize] = row as u32;
            next[node as usize] += 1;
        }
        Self { starts, entries }
    }

    /// The rows of a node.
    #[must_use]
    pub fn of(&self, node: usize) -> &[u32] {
        &self.entries[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}
