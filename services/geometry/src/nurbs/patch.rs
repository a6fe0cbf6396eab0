//! A surface over two axes, with control points and weights.

use super::{KnotSpan, MOST_FUNCTIONS, NurbsError, SplineAxis};
use crate::math::Vec3;

/// A NURBS surface. Control points and weights run along the first axis fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsPatch {
    axes: [SplineAxis; 2],
    points: Vec<Vec3>,
    weights: Vec<f64>,
}

/// The functions that are not zero at a point: control points, values and derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchBasis {
    /// How many.
    pub count: usize,
    /// Their control points.
    pub nodes: [u32; MOST_FUNCTIONS],
    /// R.
    pub value: [f64; MOST_FUNCTIONS],
    /// R,1 R,2 R,11 R,22 R,12 by the parameters.
    pub derivatives: [[f64; MOST_FUNCTIONS]; 5],
}

impl NurbsPatch {
    /// Checks and keeps.
    ///
    /// # Errors
    /// Numbers of points or weights that do not fit, and values that are none.
    pub fn new(
        axes: [SplineAxis; 2],
        points: Vec<Vec3>,
        weights: Vec<f64>,
    ) -> Result<Self, NurbsError> {
        let wanted = axes[0].functions() * axes[1].functions();
        for (what, found) in [("control points", points.len()), ("weights", weights.len())] {
            if found != wanted {
                return Err(NurbsError::Count { what, found, wanted });
            }
        }
        let bad = |p: &Vec3| p.iter().any(|x| !x.is_finite());
        if let Some(index) = points.iter().position(bad) {
            return Err(NurbsError::Value { what: "control point", index, wanted: "finite" });
        }
        if let Some(index) = weights.iter().position(|w| !(w.is_finite() && *w > 0.0)) {
            return Err(NurbsError::Value { what: "weight", index, wanted: "positive" });
        }
        Ok(Self { axes, points, weights })
    }

    /// A flat sheet in the plane z = 0, its middle in the origin: `size` \[m\] in x and y.
    ///
    /// # Errors
    /// As [`SplineAxis::uniform`].
    pub fn sheet(size: [f64; 2], cells: [usize; 2], degree: usize) -> Result<Self, NurbsError> {
        let axes = [SplineAxis::uniform(degree, cells[0])?, SplineAxis::uniform(degree, cells[1])?];
        let along = |axis: usize, i: usize| {
            (axes[axis].greville(i) / cells[axis] as f64 - 0.5) * size[axis]
        };
        let mut points = Vec::new();
        for j in 0..axes[1].functions() {
            for i in 0..axes[0].functions() {
                points.push(Vec3::new(along(0, i), along(1, j), 0.0));
            }
        }
        let weights = vec![1.0; points.len()];
        Self::new(axes, points, weights)
    }

    /// An arc of up to a quarter turn about z of a profile that is itself one arc or line: exact.
    /// `profile` has radius, height \[m\] and weight of its three control points.
    ///
    /// # Errors
    /// A weight that is not positive.
    pub fn revolved(profile: [[f64; 3]; 3], angle: f64) -> Result<Self, NurbsError> {
        let axis = SplineAxis::uniform(2, 1)?;
        let (sin, cos) = libm::sincos(angle);
        let half = libm::cos(0.5 * angle);
        let (sin_half, cos_half) = libm::sincos(0.5 * angle);
        let around = [[1.0, 0.0, 1.0], [cos_half / half, sin_half / half, half], [cos, sin, 1.0]];
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for [r, z, w] in profile {
            for [x, y, share] in around {
                points.push(Vec3::new(r * x, r * y, z));
                weights.push(w * share);
            }
        }
        Self::new([axis.clone(), axis], points, weights)
    }

    /// The same surface with each span divided into `parts` equal ones along the two axes; of
    /// clamped axes only.
    #[must_use]
    pub fn divided(mut self, parts: [usize; 2]) -> Self {
        for (axis, &count) in parts.iter().enumerate() {
            let spans = self.axes[axis].spans();
            for span in spans {
                for part in 1..count {
                    let at = span.start + span.length * part as f64 / count as f64;
                    self.insert(axis, at);
                }
            }
        }
        self
    }

    /// Inserts a knot.
    fn insert(&mut self, axis: usize, value: f64) {
        let before = [0, 1].map(|a| self.axes[a].functions());
        let (refined, shares) = self.axes[axis].with_knot(value);
        let mut after = before;
        after[axis] += 1;
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for j in 0..after[1] {
            for i in 0..after[0] {
                let place = [i, j][axis];
                let old = |k: usize| {
                    let at = if axis == 0 { [k, j] } else { [i, k] };
                    let n = at[1] * before[0] + at[0];
                    (self.points[n] * self.weights[n], self.weights[n])
                };
                let share = shares[place];
                let ((p, w), (q, v)) = match share {
                    0.0 => (old(place - 1), (Vec3::zeros(), 0.0)),
                    1.0 => ((Vec3::zeros(), 0.0), old(place)),
                    _ => (old(place - 1), old(place)),
                };
                let weight = (1.0 - share) * w + share * v;
                points.push((p * (1.0 - share) + q * share) / weight);
                weights.push(weight);
            }
        }
        self.axes[axis] = refined;
        (self.points, self.weights) = (points, weights);
    }

    /// Its axes.
    #[must_use]
    pub fn axes(&self) -> &[SplineAxis; 2] {
        &self.axes
    }

    /// Its control points \[m\].
    #[must_use]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The functions at the shares `at` of two spans.
    #[must_use]
    pub fn evaluate(&self, spans: [&KnotSpan; 2], at: [f64; 2]) -> PatchBasis {
        let basis = [0, 1].map(|a| self.axes[a].evaluate(spans[a], at[a]));
        let orders = [0, 1].map(|a| self.axes[a].degree() + 1);
        let count = orders[0] * orders[1];
        let (mut nodes, mut value) = ([0; MOST_FUNCTIONS], [0.0; MOST_FUNCTIONS]);
        let mut derivatives = [[0.0; MOST_FUNCTIONS]; 5];
        for j in 0..orders[1] {
            for i in 0..orders[0] {
                let k = j * orders[0] + i;
                let column = self.axes[0].function(spans[0], i);
                let row = self.axes[1].function(spans[1], j);
                nodes[k] = (row * self.axes[0].functions() + column) as u32;
                let ([u, v], [du, dv]) = ([basis[0].value[i], basis[1].value[j]], {
                    [basis[0].first[i], basis[1].first[j]]
                });
                value[k] = u * v;
                let of = [du * v, u * dv, basis[0].second[i] * v, u * basis[1].second[j], du * dv];
                (0..5).for_each(|d| derivatives[d][k] = of[d]);
            }
        }
        let mut found = PatchBasis { count, nodes, value, derivatives };
        if self.weights.iter().any(|&w| w != 1.0) {
            found.weigh(&self.weights);
        }
        found
    }

    /// Where the surface is there \[m\].
    #[must_use]
    pub fn place(&self, basis: &PatchBasis) -> Vec3 {
        (0..basis.count).map(|k| self.points[basis.nodes[k] as usize] * basis.value[k]).sum()
    }
}

impl PatchBasis {
    /// From B-splines N to R = N w/W with W = Σ N w, and its derivatives by the quotient rule.
    fn weigh(&mut self, weights: &[f64]) {
        let w: Vec<f64> = (0..self.count).map(|k| weights[self.nodes[k] as usize]).collect();
        let sum =
            |row: &[f64; MOST_FUNCTIONS]| -> f64 { w.iter().zip(row).map(|(w, n)| w * n).sum() };
        let total = sum(&self.value);
        let [w1, w2, w11, w22, w12] = self.derivatives.map(|row| sum(&row));
        for (k, w) in w.iter().enumerate() {
            let [n1, n2, n11, n22, n12] = self.derivatives.map(|row| row[k] * w);
            let r = self.value[k] * w / total;
            let r1 = (n1 - r * w1) / total;
            let r2 = (n2 - r * w2) / total;
            self.value[k] = r;
            let of = [
                r1,
                r2,
                (n11 - 2.0 * r1 * w1 - r * w11) / total,
                (n22 - 2.0 * r2 * w2 - r * w22) / total,
                (n12 - r1 * w2 - r2 * w1 - r * w12) / total,
            ];
            (0..5).for_each(|d| self.derivatives[d][k] = of[d]);
        }
    }
}
