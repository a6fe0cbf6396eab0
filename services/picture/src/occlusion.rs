//! How much of the ambient light reaches a sample: less where other surfaces stand close over it.

use super::camera::Camera;
use super::raster::Buffers;
use cullet_geometry::Vec3;
use std::ops::Range;

/// Farthest that a sample looks around itself \[samples\].
pub(super) const FARTHEST: usize = 40;
/// Nearest that it looks \[samples\].
const NEAREST: f32 = 2.0;
/// Sizes of the pattern, from nothing to [`FARTHEST`]: one for every half sample.
const SIZES: usize = 2 * FARTHEST + 1;
/// Where a sample looks, in eighths of how far it looks.
const PATTERN: [(f32, f32); 6] =
    [(8.0, 1.0), (-3.0, 2.0), (1.0, -7.0), (2.0, 4.0), (-6.0, -4.0), (4.0, -3.0)];
/// Quarter turns of the pattern: the samples of a pixel have one each, and their mean is smooth.
const TURNS: usize = 4;

/// The pattern in samples to the right and down, at each size and turn.
pub(super) struct AmbientOcclusion {
    offsets: Vec<[[(i32, i32); PATTERN.len()]; TURNS]>,
}

/// Turns a pattern by quarters.
pub(super) const fn turned(dx: f32, dy: f32, turn: usize) -> (f32, f32) {
    match turn % TURNS {
        0 => (dx, dy),
        1 => (-dy, dx),
        2 => (dy, -dx),
        _ => (-dx, -dy),
    }
}

impl Default for AmbientOcclusion {
    fn default() -> Self {
        let at = |size: usize, turn: usize, k: usize| {
            let (dx, dy) = turned(PATTERN[k].0, PATTERN[k].1, turn);
            let eighth = size as f32 / 16.0;
            ((dx * eighth) as i32, (dy * eighth) as i32)
        };
        let turns = |size| std::array::from_fn(|turn| std::array::from_fn(|k| at(size, turn, k)));
        Self { offsets: (0..SIZES).map(turns).collect() }
    }
}

/// From where samples are looked at, and how far surfaces darken each other.
pub(super) struct Viewpoint {
    focal: f64,
    axes: [Vec3; 3],
    /// How far a surface darkens its neighbours \[m\].
    contact: f64,
}

impl Viewpoint {
    pub(super) fn new(camera: &Camera, contact: f64) -> Self {
        let axes = [camera.right, camera.above, camera.forward];
        Self { focal: camera.focal, axes, contact }
    }

    /// A direction in the axes of the eye.
    fn to_eye(&self, n: [f32; 3]) -> [f32; 3] {
        let n = Vec3::from(n.map(f64::from));
        self.axes.map(|axis| n.dot(&axis) as f32)
    }
}

/// A sample and the plane of its surface.
struct SurfaceSample {
    x: usize,
    y: usize,
    /// Distance \[m\].
    here: f32,
    /// How much nearer the plane comes with each sample to the right and down \[m\].
    slope: (f32, f32),
    /// How far a surface darkens its neighbours \[m\].
    reach: f32,
}

impl AmbientOcclusion {
    /// Share of the ambient light that surfaces close by let through. `turns`: of the pattern.
    pub(super) fn open(
        &self,
        view: &Viewpoint,
        seen: &Buffers,
        index: usize,
        turns: Range<usize>,
    ) -> f32 {
        let (here, focal) = (1.0 / seen.near[index], view.focal as f32);
        let reach = view.contact as f32;
        let far = (focal * reach / here).clamp(NEAREST, FARTHEST as f32);
        let [nx, ny, nz] = view.to_eye(seen.normal[index]);
        // Seen edge-on, any neighbour may be nearer without standing over it.
        let steep = here / focal / (-nz).max(0.15);
        let slope = (-nx * steep, ny * steep);
        let (x, y) = (index % seen.width, index / seen.width);
        let spot = SurfaceSample { x, y, here, slope, reach };
        let patterns = &self.offsets[(2.0 * far) as usize];
        let taps = (PATTERN.len() * turns.len()) as f32;
        // The first turn and the last are opposite: where both find nothing, there is nothing.
        let (first, rest) = (turns.start, turns.start + 1..turns.end);
        let mut sum = spot.all(seen, &patterns[first]);
        if !rest.is_empty() {
            let last = rest.end - 1;
            sum += spot.all(seen, &patterns[last]);
            if sum > 0.0 {
                sum += patterns[rest.start..last].iter().map(|p| spot.all(seen, p)).sum::<f32>();
            }
        }
        1.0 - 0.85 * (sum / taps).min(1.0)
    }
}

impl SurfaceSample {
    fn all(&self, seen: &Buffers, offsets: &[(i32, i32); PATTERN.len()]) -> f32 {
        let mut sum = 0.0;
        for &offset in offsets {
            sum += self.shut(seen, offset);
        }
        sum
    }

    /// How much the surface seen at an offset stands over this one \[1\].
    #[inline]
    fn shut(&self, seen: &Buffers, (du, dv): (i32, i32)) -> f32 {
        // What is below zero is beyond the end too.
        let (u, v) =
            (self.x.wrapping_add_signed(du as isize), self.y.wrapping_add_signed(dv as isize));
        if u >= seen.width || v >= seen.height {
            return 0.0;
        }
        let near = seen.near[v * seen.width + u];
        let plane = self.here - (self.slope.0 * du as f32 + self.slope.1 * dv as f32);
        // Whether it stands over the plane by 0.02 reach, and not so far before it that it hides it
        // without touching it: asked of 1/distance, which needs no division.
        let over = near * (plane - 0.02 * self.reach) > 1.0;
        let close = near * (self.here - 3.0 * self.reach) < 1.0;
        if over && close && near > 0.0 { ((plane - 1.0 / near) / self.reach).min(1.0) } else { 0.0 }
    }
}
