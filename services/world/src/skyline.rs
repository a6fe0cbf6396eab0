//! A symmetric positive definite matrix between the first entry of each row and its diagonal, and
//! its Cholesky factor, which fills nothing else.

/// The lower triangle, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Skyline {
    /// First column of each row.
    first: Vec<usize>,
    /// Where each row begins; one more than there are rows.
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Skyline {
    /// Zero, with the first column of each row.
    pub(crate) fn new(first: Vec<usize>) -> Self {
        let mut rows = Vec::with_capacity(first.len() + 1);
        rows.push(0);
        for (row, from) in first.iter().enumerate() {
            rows.push(rows[row] + row + 1 - from);
        }
        let values = vec![0.0; rows[first.len()]];
        Self { first, rows, values }
    }

    /// About how many multiplications the factor takes.
    pub(crate) fn cost(first: &[usize]) -> f64 {
        first
            .iter()
            .enumerate()
            .map(|(row, from)| ((row - from) as f64) * ((row - from) as f64))
            .sum()
    }

    /// Adds to an entry; whether it is one of those kept. The column is at most the row.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) -> bool {
        let kept = column >= self.first[row];
        if kept {
            self.values[self.rows[row] + column - self.first[row]] += value;
        }
        kept
    }

    /// Does it keep this entry?
    pub(crate) fn keeps(&self, row: usize, column: usize) -> bool {
        column >= self.first[row]
    }

    /// How many rows it has.
    pub(crate) fn len(&self) -> usize {
        self.first.len()
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.values[self.rows[row]..self.rows[row + 1]]
    }

    /// Replaces it by its Cholesky factor. A pivot that rounding made nothing is one of `least` of
    /// its diagonal.
    pub(crate) fn factor(&mut self, least: f64) {
        for i in 0..self.first.len() {
            let (done, rest) = self.values.split_at_mut(self.rows[i]);
            let from = self.first[i];
            let own = &mut rest[..=i - from];
            for j in from..i {
                let start = self.first[j];
                let other = &done[self.rows[j]..self.rows[j + 1]];
                let common = from.max(start);
                let sum = dot(&own[common - from..j - from], &other[common - start..j - start]);
                own[j - from] = (own[j - from] - sum) / other[j - start];
            }
            let diagonal = own[i - from];
            let pivot = diagonal - dot(&own[..i - from], &own[..i - from]);
            let pivot = if pivot > least * diagonal { pivot } else { least * diagonal };
            own[i - from] = pivot.sqrt();
        }
    }

    /// Solves with the factor, in place.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        for i in 0..self.first.len() {
            let (row, from) = (self.row(i), self.first[i]);
            let sum = dot(&row[..i - from], &x[from..i]);
            x[i] = (x[i] - sum) / row[i - from];
        }
        for i in (0..self.first.len()).rev() {
            let (row, from) = (self.row(i), self.first[i]);
            x[i] /= row[i - from];
            let value = x[i];
            for (y, l) in x[from..i].iter_mut().zip(row) {
                *y -= l * value;
            }
        }
    }
}

/// In four sums, always in the same order.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (fours_a, fours_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = fours_a.remainder().iter().zip(fours_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in fours_a.zip(fours_b) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_solves_what_it_was_made_of() {
        let first = vec![0, 0, 1, 0, 2, 4];
        let n = first.len();
        let mut matrix = Skyline::new(first.clone());
        let mut full = vec![vec![0.0; n]; n];
        let places = (0..n).flat_map(|i| (first[i]..=i).map(move |j| (i, j)).collect::<Vec<_>>());
        for (i, j) in places {
            let value = if i == j { 9.0 + i as f64 } else { 1.0 / (1.0 + (i * j) as f64) };
            assert!(matrix.add(i, j, value));
            (full[i][j], full[j][i]) = (value, value);
        }
        assert!(!matrix.add(5, 3, 1.0));
        let want: Vec<f64> = (0..n).map(|k| k as f64 - 2.3).collect();
        let mut x: Vec<f64> = full.iter().map(|row| dot(row, &want)).collect();
        matrix.factor(1e-14);
        matrix.solve(&mut x);
        let off = x.iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{off}");
    }
}
