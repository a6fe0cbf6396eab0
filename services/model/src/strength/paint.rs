//! Factors that a scene paints: by region, or on the surface.

use cullet_geometry::Vec3;
use std::sync::Arc;

/// A part of space, pattern frame \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Region {
    /// A box along the axes.
    Box {
        /// Lowest corner.
        low: Vec3,
        /// Highest corner.
        high: Vec3,
    },
    /// A ball.
    Sphere {
        /// Centre.
        centre: Vec3,
        /// Radius.
        radius: f64,
    },
    /// All that lies against the normal of a plane.
    HalfSpace {
        /// A point of the plane.
        point: Vec3,
        /// Unit normal, out of the half-space.
        normal: Vec3,
    },
    /// A cylinder.
    Cylinder {
        /// Middle of one end.
        from: Vec3,
        /// Middle of the other.
        to: Vec3,
        /// Radius.
        radius: f64,
    },
    /// A score line: a straight groove under a line on the surface. Grooves of one factor of which
    /// each begins where the last ends are one line.
    Groove {
        /// One end of the line.
        from: Vec3,
        /// The other.
        to: Vec3,
        /// From the line to the bottom of the groove, across the line.
        inward: Vec3,
        /// Half of its width, beyond its ends and above the surface too; it is never less than
        /// [`GROOVE`] spacings.
        half_width: f64,
    },
}

/// Least half of the width of a groove in spacings: three columns of points of a solve lie in it.
pub const GROOVE: f64 = 0.75;

/// A region whose strength is multiplied.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Stroke {
    /// Name of the region that it acts on.
    pub region: Region,
    /// Strength within over strength without \[1\].
    pub factor: f64,
    /// Width of the seam over which the factor comes in, half of it within \[m\].
    pub edge: f64,
}

/// Factors at points of the surface; between them they are weighted by distance.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexPaint {
    /// Where, pattern frame \[m\].
    pub points: Vec<Vec3>,
    /// Strength over unpainted strength at each \[1\].
    pub factors: Vec<f64>,
    /// How deep the paint goes \[m\]: from there on nothing is painted.
    pub reach: f64,
}

impl Region {
    /// Whether a point lies within, or no farther outside than `slack` \[m\].
    #[must_use]
    pub fn contains(&self, x: &Vec3, slack: f64) -> bool {
        self.distance(x) <= slack
    }

    /// Distance to the boundary, negative within \[m\].
    fn distance(&self, x: &Vec3) -> f64 {
        let corner = |out: &[f64]| {
            let far = out.iter().map(|o| o.max(0.0) * o.max(0.0)).sum::<f64>().sqrt();
            far + out.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
        };
        match *self {
            Self::Box { low, high } => {
                let out = (x - (low + high) / 2.0).abs() - (high - low) / 2.0;
                corner(out.as_slice())
            }
            Self::Sphere { centre, radius } => (x - centre).norm() - radius,
            Self::HalfSpace { point, normal } => (x - point).dot(&normal),
            Self::Cylinder { from, to, radius } => {
                let length = (to - from).norm();
                let axis = (to - from) / length;
                let along = (x - from).dot(&axis);
                let across = (x - from - axis * along).norm();
                corner(&[across - radius, (along - length / 2.0).abs() - length / 2.0])
            }
            Self::Groove { from, to, inward, half_width } => {
                let (axis, down) = ((to - from).normalize(), inward.normalize());
                let middle = 0.5 * (from + to + inward);
                let reach = [(to - from).norm(), inward.norm()].map(|l| 0.5 * l + half_width);
                let out = |way: &Vec3, reach: f64| (x - middle).dot(way).abs() - reach;
                corner(&[
                    out(&axis.cross(&down), half_width),
                    out(&axis, reach[0]),
                    out(&down, reach[1]),
                ])
            }
        }
    }
}

impl Stroke {
    /// The same for a solve of that spacing \[m\].
    pub(super) fn resolved(mut self, spacing: f64) -> Self {
        if let Region::Groove { half_width, .. } = &mut self.region {
            *half_width = half_width.max(GROOVE * spacing);
        }
        self
    }

    /// Whether it goes on where another ends, as grooves of one line do.
    fn goes_on(&self, last: &Self) -> bool {
        match (last.region, self.region) {
            (Region::Groove { to, .. }, Region::Groove { from, .. }) => {
                to == from && self.factor == last.factor
            }
            _ => false,
        }
    }

    /// The factor at a point: smooth over the seam.
    pub(super) fn factor_at(&self, x: &Vec3) -> f64 {
        let distance = self.region.distance(x);
        let share = if self.edge > 0.0 {
            let t = (0.5 - distance / self.edge).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        } else {
            f64::from(u8::from(distance <= 0.0))
        };
        1.0 + share * (self.factor - 1.0)
    }
}

/// The product of all factors at a point; the grooves of one line count once.
pub(super) fn painted(strokes: &[Stroke], x: &Vec3) -> f64 {
    let lines = strokes.chunk_by(|last, next| next.goes_on(last));
    let factor = |line: &[Stroke]| match line {
        [one] => one.factor_at(x),
        many => many.iter().map(|own| own.factor_at(x)).fold(1.0, f64::min),
    };
    lines.map(factor).product()
}

/// The least product of factors below 1 that strokes can have together.
#[must_use]
pub fn weakest_painted(strokes: &[Stroke]) -> f64 {
    let lines = strokes.chunk_by(|last, next| next.goes_on(last));
    lines.filter_map(|line| line.first()).map(|own| own.factor.min(1.0)).product()
}

/// Painted points sorted into cells as wide as the reach.
#[derive(Clone, Debug)]
pub(super) struct Brush {
    paint: Arc<VertexPaint>,
    /// Cell and point, in order.
    cells: Vec<([i64; 3], u32)>,
}

impl Brush {
    pub(super) fn new(paint: &Arc<VertexPaint>) -> Self {
        let points = paint.points.iter().enumerate();
        let mut cells: Vec<_> =
            points.map(|(index, point)| (cell(point, paint.reach), index as u32)).collect();
        cells.sort_unstable();
        Self { paint: Arc::clone(paint), cells }
    }

    /// 1 + w (f̄ − 1), where f̄ is the mean of the factors within reach by the weights
    /// (1 − (d/reach)²)², and w the greatest of these.
    pub(super) fn factor(&self, x: &Vec3) -> f64 {
        let VertexPaint { points, factors, reach } = &*self.paint;
        let [i, j, k] = cell(x, *reach);
        let (mut sum, mut weights, mut greatest) = (0.0, 0.0, 0.0_f64);
        for (di, dj) in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj))) {
            // The three cells along the last axis follow one another.
            let (low, high) = ([i + di, j + dj, k - 1], [i + di, j + dj, k + 1]);
            let start = self.cells.partition_point(|(cell, _)| *cell < low);
            let row = self.cells[start..].iter().take_while(|(cell, _)| *cell <= high);
            for index in row.map(|(_, index)| *index as usize) {
                let ratio = (points[index] - x).norm_squared() / (reach * reach);
                let weight = (1.0 - ratio).max(0.0) * (1.0 - ratio).max(0.0);
                sum += weight * factors[index];
                weights += weight;
                greatest = greatest.max(weight);
            }
        }
        if weights > 0.0 { 1.0 + greatest * (sum / weights - 1.0) } else { 1.0 }
    }
}

fn cell(x: &Vec3, width: f64) -> [i64; 3] {
    [x.x, x.y, x.z].map(|value| (value / width).floor() as i64)
}
