//! One direction of a patch: B-spline functions over knots.

use super::{DEGREES, NurbsError};

/// B-splines of one degree over knots, clamped at both ends or closed to a ring.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineAxis {
    degree: usize,
    knots: Vec<f64>,
    periodic: bool,
}

/// An interval between two different knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnotSpan {
    /// The first function that is not zero on it.
    pub first: usize,
    /// Its left knot, by place in the list.
    knot: usize,
    /// Parameter at its left end \[1\].
    pub start: f64,
    /// Its length \[1\].
    pub length: f64,
}

/// Values and derivatives by the parameter of the functions on a span, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisBasis {
    /// Values.
    pub value: [f64; DEGREES.1 + 1],
    /// First derivatives.
    pub first: [f64; DEGREES.1 + 1],
    /// Second derivatives.
    pub second: [f64; DEGREES.1 + 1],
}

impl SplineAxis {
    /// Clamped at both ends, with knots 0, 1, 2 … `cells`.
    ///
    /// # Errors
    /// A degree that is not supported, or no cell.
    pub fn uniform(degree: usize, cells: usize) -> Result<Self, NurbsError> {
        check_degree(degree)?;
        check_cells(cells, 1)?;
        let last = cells as f64;
        let inner = (1..cells).map(|k| k as f64);
        let ends = |value| std::iter::repeat_n(value, degree + 1);
        let knots = ends(0.0).chain(inner).chain(ends(last)).collect();
        Ok(Self { degree, knots, periodic: false })
    }

    /// A ring of `cells` cells of length 1.
    ///
    /// # Errors
    /// A degree that is not supported, or so few cells that a function would meet itself.
    pub fn ring(degree: usize, cells: usize) -> Result<Self, NurbsError> {
        check_degree(degree)?;
        check_cells(cells, degree + 1)?;
        let knots = (0..=cells + 2 * degree).map(|k| k as f64 - degree as f64).collect();
        Ok(Self { degree, knots, periodic: true })
    }

    /// Over the given knots, clamped at both ends.
    ///
    /// # Errors
    /// Knots that decrease, are not clamped, or repeat so often that the surface has a crease.
    pub fn clamped(degree: usize, knots: Vec<f64>) -> Result<Self, NurbsError> {
        check_degree(degree)?;
        let bad = |i: &usize| !knots[*i].is_finite() || (*i > 0 && knots[*i] < knots[*i - 1]);
        if let Some(index) = (0..knots.len()).find(bad) {
            return Err(NurbsError::Knot { index, value: knots[index] });
        }
        check_cells(knots.len().saturating_sub(2 * degree + 1), 1)?;
        let times = |value: f64| knots.iter().filter(|&&k| k == value).count();
        for (end, value) in [("first", knots[0]), ("last", knots[knots.len() - 1])] {
            if times(value) != degree + 1 {
                return Err(NurbsError::Clamped { end, wanted: degree + 1, times: times(value) });
            }
        }
        let most = degree - 1;
        let inner = &knots[degree + 1..knots.len() - degree - 1];
        if let Some(&value) = inner.iter().find(|&&value| times(value) > most) {
            return Err(NurbsError::Crease { value, times: times(value), degree, most });
        }
        Ok(Self { degree, knots, periodic: false })
    }

    /// Degree of the functions.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Whether it is a ring.
    #[must_use]
    pub fn is_ring(&self) -> bool {
        self.periodic
    }

    /// Its knots.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of functions.
    #[must_use]
    pub fn functions(&self) -> usize {
        let open = self.knots.len() - self.degree - 1;
        if self.periodic { open - self.degree } else { open }
    }

    /// The function in that place of a span's; on a ring those beyond the last begin anew.
    #[must_use]
    pub fn function(&self, span: &KnotSpan, place: usize) -> usize {
        (span.first + place) % self.functions()
    }

    /// Its spans, in order.
    #[must_use]
    pub fn spans(&self) -> Vec<KnotSpan> {
        let (p, knots) = (self.degree, &self.knots);
        (p..knots.len() - p - 1)
            .filter(|&k| knots[k + 1] > knots[k])
            .map(|k| KnotSpan {
                first: k - p,
                knot: k,
                start: knots[k],
                length: knots[k + 1] - knots[k],
            })
            .collect()
    }

    /// Mean of the knots inside a function: where its control point belongs.
    #[must_use]
    pub fn greville(&self, function: usize) -> f64 {
        let inside = &self.knots[function + 1..=function + self.degree];
        inside.iter().sum::<f64>() / self.degree as f64
    }

    /// The functions at the share `at` of a span \[0, 1\]. Spans with knots at equal distances give
    /// equal bits, wherever they lie.
    #[must_use]
    pub fn evaluate(&self, span: &KnotSpan, at: f64) -> AxisBasis {
        let (p, k) = (self.degree, span.knot);
        let t = at * span.length;
        // Differences of knots come first: they are what equal cells have in common.
        let left = |j: usize| t + (self.knots[k] - self.knots[k + 1 - j]);
        let right = |j: usize| (self.knots[k + j] - self.knots[k]) - t;
        let mut rows = [[0.0; DEGREES.1 + 1]; DEGREES.1 + 1];
        rows[0][0] = 1.0;
        for d in 1..=p {
            let lower = rows[d - 1];
            let mut saved = 0.0;
            for (r, value) in lower.iter().enumerate().take(d) {
                let share = value / (right(r + 1) + left(d - r));
                rows[d][r] = saved + right(r + 1) * share;
                saved = left(d - r) * share;
            }
            rows[d][d] = saved;
        }
        let first = self.derived(k, p, &rows[p - 1]);
        let lower = self.derived(k, p - 1, &rows[p - 2]);
        AxisBasis { value: rows[p], first, second: self.derived(k, p, &lower) }
    }

    /// Derivatives of degree `d` from what the functions of degree d − 1 are:
    /// N' = d (N_i/(k_{i+d} − k_i) − N_{i+1}/(k_{i+d+1} − k_{i+1})).
    fn derived(&self, k: usize, d: usize, lower: &[f64; DEGREES.1 + 1]) -> [f64; DEGREES.1 + 1] {
        let mut out = [0.0; DEGREES.1 + 1];
        for (r, value) in lower.iter().enumerate().take(d) {
            // Function r of degree d − 1 on this span begins at knot k − d + 1 + r.
            let begin = k + 1 + r - d;
            let share = d as f64 * value / (self.knots[begin + d] - self.knots[begin]);
            out[r] -= share;
            out[r + 1] += share;
        }
        out
    }

    /// The axis with a knot more, and for each new function the old ones that it is made of:
    /// new = (1 − α) old_{i−1} + α old_i (Boehm). Clamped axes only.
    pub(super) fn with_knot(&self, value: f64) -> (Self, Vec<f64>) {
        let (p, knots) = (self.degree, &self.knots);
        let k = knots.partition_point(|&knot| knot <= value) - 1;
        let mut shares = vec![0.0; self.functions() + 1];
        for (i, share) in shares.iter_mut().enumerate() {
            *share = if i + p <= k {
                1.0
            } else if i > k {
                0.0
            } else {
                (value - knots[i]) / (knots[i + p] - knots[i])
            };
        }
        let mut refined = self.clone();
        refined.knots.insert(k + 1, value);
        (refined, shares)
    }
}

fn check_degree(degree: usize) -> Result<(), NurbsError> {
    match (DEGREES.0..=DEGREES.1).contains(&degree) {
        true => Ok(()),
        false => Err(NurbsError::Degree(degree)),
    }
}

fn check_cells(cells: usize, least: usize) -> Result<(), NurbsError> {
    if cells < least { Err(NurbsError::Cells { cells, least }) } else { Ok(()) }
}
