//! The outline of a sheet: a polygon that does not cross itself.

use cullet_model::{Refusal, SheetPlace};
use robust::{Coord, orient2d};

/// Positive where `c` lies to the left of the way from `a` to `b`; exact in sign.
pub(crate) fn turn(a: SheetPlace, b: SheetPlace, c: SheetPlace) -> f64 {
    let at = |[x, y]: SheetPlace| Coord { x, y };
    orient2d(at(a), at(b), at(c))
}

/// Whether two segments meet, touching included.
pub(crate) fn meet(a: SheetPlace, b: SheetPlace, c: SheetPlace, d: SheetPlace) -> bool {
    let apart = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    let box_apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    if box_apart(0) || box_apart(1) {
        return false;
    }
    !apart(turn(a, b, c), turn(a, b, d)) && !apart(turn(c, d, a), turn(c, d, b))
}

/// Squared distance of a place from a segment \[m²\].
fn distance_squared(p: SheetPlace, a: SheetPlace, b: SheetPlace) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = along[0] * along[0] + along[1] * along[1];
    let share = if length > 0.0 { (along[0] * to[0] + along[1] * to[1]) / length } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    let (x, y) = (to[0] - share * along[0], to[1] - share * along[1]);
    x * x + y * y
}

/// Area \[m²\] and centroid \[m\] of a polygon, counter-clockwise positive; the first corner where
/// there is no area.
pub(crate) fn area_and_centroid(corners: &[SheetPlace]) -> (f64, SheetPlace) {
    let Some(&[ox, oy]) = corners.first() else {
        return (0.0, [0.0; 2]);
    };
    let (mut twice, mut mx, mut my) = (0.0, 0.0, 0.0);
    for (k, p) in corners.iter().enumerate() {
        let q = corners[(k + 1) % corners.len()];
        let (ax, ay, bx, by) = (p[0] - ox, p[1] - oy, q[0] - ox, q[1] - oy);
        let cross = ax * by - bx * ay;
        twice += cross;
        mx += cross * (ax + bx);
        my += cross * (ay + by);
    }
    match twice == 0.0 {
        true => (0.0, [ox, oy]),
        false => (0.5 * twice, [ox + mx / (3.0 * twice), oy + my / (3.0 * twice)]),
    }
}

/// A polygon, counter-clockwise.
#[derive(Clone, Debug)]
pub(crate) struct SheetOutline {
    /// Its corners \[m\].
    pub(crate) corners: Vec<SheetPlace>,
    /// \[m²\].
    pub(crate) area: f64,
    /// Its least and greatest coordinates \[m\].
    pub(crate) bounds: [SheetPlace; 2],
}

impl SheetOutline {
    /// # Errors
    ///
    /// If it has fewer than three corners, a coordinate is no number, it crosses itself, or it runs
    /// clockwise.
    pub(crate) fn new(corners: &[SheetPlace]) -> Result<Self, Refusal> {
        let unfit = |lack: String| Err(Refusal::Unfit { solver: crate::family::NAME, lack });
        if corners.len() < 3 || !corners.iter().flatten().all(|c| c.is_finite()) {
            return unfit(
                "the outline needs at least 3 corners with finite coordinates".to_owned(),
            );
        }
        let n = corners.len();
        for i in 0..n {
            for j in i + 2..n {
                let neighbours = i == 0 && j == n - 1;
                let (next, after) = (corners[i + 1], corners[(j + 1) % n]);
                if !neighbours && meet(corners[i], next, corners[j], after) {
                    return unfit(format!("edges {i} and {j} of the outline meet"));
                }
            }
        }
        let (area, _) = area_and_centroid(corners);
        if area <= 0.0 {
            return unfit("the outline must run counter-clockwise around an area".to_owned());
        }
        let mut bounds = [corners[0]; 2];
        for p in corners {
            for k in 0..2 {
                bounds[0][k] = bounds[0][k].min(p[k]);
                bounds[1][k] = bounds[1][k].max(p[k]);
            }
        }
        Ok(Self { corners: corners.to_vec(), area, bounds })
    }

    fn edges(&self) -> impl Iterator<Item = (SheetPlace, SheetPlace)> + '_ {
        let next = |k: usize| self.corners[(k + 1) % self.corners.len()];
        self.corners.iter().enumerate().map(move |(k, &p)| (p, next(k)))
    }

    /// Whether a place is inside.
    pub(crate) fn contains(&self, p: SheetPlace) -> bool {
        let mut inside = false;
        for (a, b) in self.edges() {
            if (a[1] > p[1]) != (b[1] > p[1]) {
                let side = turn(a, b, p);
                inside ^= if b[1] > a[1] { side > 0.0 } else { side < 0.0 };
            }
        }
        inside
    }

    /// Distance of a place from its edges \[m\].
    pub(crate) fn distance(&self, p: SheetPlace) -> f64 {
        let least = self.edges().map(|(a, b)| distance_squared(p, a, b));
        least.fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Whether a segment meets an edge.
    pub(crate) fn is_met_by(&self, a: SheetPlace, b: SheetPlace) -> bool {
        self.edges().any(|(c, d)| meet(a, b, c, d))
    }
}

#[cfg(test)]
mod tests {
    use super::{SheetOutline, meet};

    #[test]
    fn a_polygon_that_crosses_itself_or_runs_backwards_is_refused() {
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(SheetOutline::new(&bow).is_err());
        let backwards = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]];
        assert!(SheetOutline::new(&backwards).is_err());
        let hook = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]];
        let hook = SheetOutline::new(&hook).unwrap();
        assert_eq!(hook.area, 3.0);
        assert!(hook.contains([1.5, 1.5]) && !hook.contains([0.5, 1.5]));
        assert_eq!(hook.distance([0.5, 1.25]), 0.25);
        assert!(hook.is_met_by([0.5, 0.9], [1.2, 1.9]));
        assert!(!meet([0.0, 0.0], [1.0, 0.0], [0.5, 0.1], [0.5, 1.0]));
    }
}
