//! Whether new crack faces lie along the planes of a grid (F22, F26).
//!
//! The measure is the share of their area within 10° of one of the grid's planes, over the share
//! 3 (1 − cos 10°) that faces of any direction have. Few faces may lie so by chance, and one
//! straight crack often does: so the same faces are measured in many frames that the grid does not
//! know, spread over all turns. Had the grid no part in it, its own frame would be one like those,
//! and the greatest of 200 in one case of 200, however many faces there are, of whatever area, and
//! however they hang together. Only where the grid's frame has the greatest share of all by far is
//! there a bias. A plane crack along the grid is none, for of the other frames one in twenty has a
//! plane along it too, while steps along two or three of the grid's planes fit no other frame. Nor
//! is there one where the points of the solve broke across the grid's planes as often.

use cullet_geometry::math::unit;
use cullet_geometry::{Mat3, Solid, Surface, Vec3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// cos 10°: a face whose normal is nearer to an axis lies along the grid \[1\].
const NEAR_AXIS: f64 = 0.984_807_753_012_208;
/// Times chance from which on faces lie along the grid \[1\].
pub const MOST: f64 = 2.0;
/// How much more often than in any other frame \[1\]: most faces of a wavy plane crack along the
/// grid, but not all, also lie along a frame that is off by a few degrees.
pub const MARGIN: f64 = 1.25;
/// Frames that the faces are measured in beside the grid's.
const FRAMES: usize = 199;
/// cos 20°: a frame with all axes nearer to the grid's is the grid's own \[1\].
const OWN: f64 = 0.939_692_620_785_908_4;
/// Directions along an edge of the cube that normals are sorted on: 1.4° in its middle.
const BINS: f64 = 64.0;
/// Seed of the frames.
const FRAMES_SEED: u64 = 0x0f22;

/// How crack faces lie in a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridBias {
    /// Share of the new faces' area along the grid's planes over chance \[1\].
    pub times: f64,
    /// The greatest such figure in the frames that the grid does not know \[1\].
    pub elsewhere: f64,
    /// The same figure of the directions across which points of the solve broke: a bar that is
    /// pulled along the grid breaks along it \[1\].
    pub solved: f64,
}

impl GridBias {
    /// Whether the grid shows in the faces: [`MOST`] times as often as chance, and [`MARGIN`] times
    /// as often as in any other frame and as the solve asks for.
    #[must_use]
    pub fn shows(&self) -> bool {
        self.times >= MOST && self.times > MARGIN * self.elsewhere.max(self.solved)
    }
}

/// Measures the new crack faces of some parts against the grid whose planes have these unit
/// normals. `counts`: whether a face there is counted. `broken`: unit normals across which points
/// of the solve broke, as far as they are known.
#[must_use]
pub fn grid_bias<'a>(
    solids: impl Iterator<Item = &'a Solid>,
    counts: impl Fn(&Vec3) -> bool,
    broken: &[Vec3],
    planes: [Vec3; 3],
) -> GridBias {
    let faces = faces(solids, counts);
    let times = times(&faces, &planes);
    let others = frames(&planes);
    let elsewhere = others.iter().map(|planes| self::times(&faces, planes)).fold(0.0, f64::max);
    GridBias { times, elsewhere, solved: self::times(broken, &planes) }
}

/// The share of areas along some planes over chance; of none, nought.
fn times(areas: &[Vec3], planes: &[Vec3; 3]) -> f64 {
    let along = |n: &&Vec3| planes.iter().any(|axis| n.dot(axis).abs() > NEAR_AXIS * n.norm());
    let sum: f64 = areas.iter().filter(along).map(Vec3::norm).sum();
    let all: f64 = areas.iter().map(Vec3::norm).sum();
    if all > 0.0 { sum / all / (3.0 * (1.0 - NEAR_AXIS)) } else { 0.0 }
}

/// The area of new crack faces by direction, opposite ones alike: vectors as long as the area.
fn faces<'a>(solids: impl Iterator<Item = &'a Solid>, counts: impl Fn(&Vec3) -> bool) -> Vec<Vec3> {
    let mut bins: BTreeMap<(usize, i32, i32), Vec3> = BTreeMap::new();
    for solid in solids {
        for (t, surface) in solid.surface.iter().enumerate() {
            if !matches!(surface, Surface::Crack { parent: 0, .. }) {
                continue;
            }
            let [a, b, c] = solid.mesh.corners(t);
            if !counts(&((a + b + c) / 3.0)) {
                continue;
            }
            let area = 0.5 * (b - a).cross(&(c - a));
            let axis = area.iamax();
            let length = area[axis].abs();
            if length > 0.0 {
                let area = if area[axis] < 0.0 { -area } else { area };
                let bin = |k: usize| (area[k] / length * 0.5 * BINS).floor() as i32;
                let key = (axis, bin((axis + 1) % 3), bin((axis + 2) % 3));
                *bins.entry(key).or_default() += area;
            }
        }
    }
    bins.into_values().collect()
}

/// Frames spread over all turns, without those that are nearly the given one.
fn frames(planes: &[Vec3; 3]) -> Vec<[Vec3; 3]> {
    let own = |frame: &[Vec3; 3]| {
        frame.iter().all(|axis| planes.iter().any(|plane| axis.dot(plane).abs() > OWN))
    };
    let all = (0..).map(|k| turn(FRAMES_SEED, k)).map(|m| [0, 1, 2].map(|k| m.column(k).into()));
    all.filter(|frame| !own(frame)).take(FRAMES).collect()
}

/// A turn, all alike likely (Shoemake, Uniform Random Rotations, 1992).
pub(crate) fn turn(seed: u64, index: u64) -> Mat3 {
    let [a, b, c] = [0, 1, 2].map(|stream| unit(seed, stream, index));
    let (one, two) = ((1.0 - a).sqrt(), a.sqrt());
    let ((s1, c1), (s2, c2)) = (libm::sincos(TAU * b), libm::sincos(TAU * c));
    let (x, y, z, w) = (one * s1, one * c1, two * s2, two * c2);
    Mat3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

#[cfg(test)]
mod tests {
    use super::{FRAMES, GridBias, grid_bias, turn};
    use cullet_geometry::math::unit;
    use cullet_geometry::{Solid, Surface, TriMesh, Vec3};

    const GRID: [Vec3; 3] =
        [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];

    /// Loose triangles of these normals and areas, all of them new crack faces.
    fn of(faces: impl Iterator<Item = Vec3>) -> GridBias {
        let mut mesh = TriMesh::default();
        for area in faces {
            let across =
                area.cross(&if area.x.abs() < 0.5 * area.norm() { Vec3::x() } else { Vec3::y() });
            let side = across.normalize() * (2.0 * area.norm()).sqrt();
            let other = area.normalize().cross(&side);
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([Vec3::zeros(), side, other]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        let crack = Surface::Crack { damage_time: [0.0; 3], front_speed: [0.0; 3], parent: 0 };
        let surface = vec![crack; mesh.triangles.len()];
        grid_bias([Solid { mesh, surface }].iter(), |_| true, &[], GRID)
    }

    /// Any direction, of any area.
    fn anyhow(seed: u64, k: u64) -> Vec3 {
        turn(seed, k) * Vec3::x() * libm::pow(unit(seed, 9, k), 3.0)
    }

    /// A staircase of voxels shows as 21.9 times chance; one plane crack along the grid, or many
    /// across one axis, do not show, for a frame in twenty has such a plane too.
    #[test]
    fn steps_show_and_planes_do_not() {
        let steps = of((0..60).map(|k| GRID[k % 3] * (1.0 + k as f64)));
        assert!(steps.shows() && (steps.times - 21.94).abs() < 0.01, "{steps:?}");
        let two = of((0..60).map(|k| GRID[k % 2]));
        assert!(two.shows(), "{two:?}");
        let plane = of([Vec3::z()].into_iter());
        assert!(!plane.shows() && plane.times > 21.9, "{plane:?}");
        let column = of((0..7).map(|k| Vec3::z() * f64::from(1 + k)));
        assert!(!column.shows(), "{column:?}");
        assert_eq!(of(std::iter::empty()), GridBias::default());
        // Where the solve broke its points across the grid's planes, faces may lie along them.
        assert!(!GridBias { solved: 18.0, ..steps }.shows());
        assert!(GridBias { solved: 1.5, ..steps }.shows());
    }

    /// Of small and large heaps of faces that know no grid, of very unequal areas, hardly one in
    /// two hundred shows it; where a tenth of a thousand faces lies along it, all do.
    #[test]
    fn chance_does_not_show_and_a_bias_does() {
        for count in [1, 2, 3, 5, 10, 30, 100, 1000] {
            let heaps = if count < 100 { 1000 } else { 200 };
            let shown =
                (0..heaps).filter(|&seed| of((0..count).map(|k| anyhow(seed, k))).shows()).count();
            // One in (frames + 1), and three standard deviations of a count.
            let mean = heaps as f64 / (FRAMES + 1) as f64;
            assert!(
                (shown as f64) <= mean + 3.0 * mean.sqrt(),
                "{shown} of {heaps}, {count} faces"
            );
        }
        let biased =
            |seed, k| if k % 10 == 0 { GRID[(k / 10 % 3) as usize] } else { anyhow(seed, k) };
        for seed in 0..20 {
            let heap = of((0..1000).map(|k| biased(seed, k)));
            assert!(heap.shows(), "{heap:?}");
        }
    }
}
