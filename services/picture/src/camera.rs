//! Where a picture is taken from.

use super::raster::ScreenCorner;
use cullet_geometry::Vec3;

/// Vertical field of view where the scene names none \[degrees\].
const FIELD: f64 = 34.0;
/// Share of the picture left free around what was fitted \[1\].
const MARGIN: f64 = 1.06;

/// Turns of fitting a view; each takes away more than half of what is amiss.
const FIT_TURNS: usize = 24;

/// The least and greatest of the numbers that are numbers.
fn range(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let finite = numbers.filter(|c| c.is_finite());
    let (low, high) = finite.fold(none, |(low, high), c| (low.min(c), high.max(c)));
    if low <= high { (low, high) } else { (-0.5, 0.5) }
}

fn middle((low, high): (f64, f64)) -> f64 {
    (low + high) / 2.0
}

/// An eye that looks at a picture of a certain size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Camera {
    pub(super) eye: Vec3,
    pub(super) right: Vec3,
    pub(super) above: Vec3,
    pub(super) forward: Vec3,
    /// Pixels per unit of slope.
    pub(super) focal: f64,
    pub(super) centre: [f64; 2],
}

/// The axes of an eye that looks along `forward` with `up` upward.
fn axes(forward: Vec3, up: Vec3) -> (Vec3, Vec3, Vec3) {
    let forward = forward.try_normalize(1e-12).unwrap_or_else(Vec3::x);
    let right = forward.cross(&up).try_normalize(1e-9).unwrap_or_else(|| {
        // Straight up or down: any right will do.
        forward.cross(&Vec3::x()).try_normalize(1e-9).unwrap_or_else(Vec3::y)
    });
    (right, right.cross(&forward), forward)
}

fn focal(height: usize, fov_degrees: f64) -> f64 {
    let half = fov_degrees.clamp(5.0, 120.0).to_radians() / 2.0;
    height as f64 / 2.0 / libm::tan(half)
}

impl Camera {
    /// Looks from `eye` at `target`.
    pub(super) fn look(
        (eye, target): (Vec3, Vec3),
        up: Vec3,
        fov_degrees: f64,
        (width, height): (usize, usize),
    ) -> Self {
        let (right, above, forward) = axes(target - eye, up);
        let centre = [width as f64 / 2.0, height as f64 / 2.0];
        Self { eye, right, above, forward, focal: focal(height, fov_degrees), centre }
    }

    /// Looks along `forward` from where `points` fill the picture.
    pub(super) fn fit(
        points: &[Vec3],
        forward: Vec3,
        up: Vec3,
        size @ (width, height): (usize, usize),
    ) -> Self {
        let (right, above, forward) = axes(forward, up);
        let along = |axis: Vec3| range(points.iter().map(|p| p.dot(&axis)));
        let (x, y, z) = (along(right), along(above), along(forward));
        let target = right * middle(x) + above * middle(y) + forward * middle(z);
        let size_of = |(low, high): (f64, f64)| (high - low).max(1e-3);
        let depth = size_of(x).max(size_of(y)).max(size_of(z));
        let mut camera = Self::look((target - forward * (3.0 * depth), target), up, FIELD, size);
        let slope = [width as f64 / 2.0 / camera.focal, height as f64 / 2.0 / camera.focal];
        // What is nearer looks larger: the middle and the size on the screen are found in turns.
        for _ in 0..FIT_TURNS {
            let local: Vec<Vec3> =
                points.iter().map(|p| camera.local(*p)).filter(|l| l.z > 1e-6).collect();
            let (x, y) =
                (range(local.iter().map(|l| l.x / l.z)), range(local.iter().map(|l| l.y / l.z)));
            let away = (target - camera.eye).dot(&forward);
            let (wide, tall) = ((x.1 - x.0) / 2.0 / slope[0], (y.1 - y.0) / 2.0 / slope[1]);
            let nearest = range(local.iter().map(|l| l.z)).0;
            // Half a step at a time, and never into what is looked at.
            let back = (MARGIN * wide.max(tall) - 1.0) * away * 0.6;
            let back = back.max(-0.6 * nearest).min(away);
            camera.eye += (right * middle(x) + above * middle(y)) * away - forward * back;
        }
        camera
    }

    /// The same view with `by` times as many pixels along each side.
    pub(super) fn scaled(&self, by: f64) -> Self {
        Self { focal: self.focal * by, centre: self.centre.map(|c| c * by), ..*self }
    }

    /// Half the diagonal of what fills the picture at a distance \[m\].
    pub(super) fn reach(&self, distance: f64, (width, height): (usize, usize)) -> f64 {
        let half = libm::hypot(width as f64, height as f64) / 2.0;
        half / self.focal * distance
    }

    /// A point in the axes of the eye: right, above, forward \[m\].
    pub(super) fn local(&self, point: Vec3) -> Vec3 {
        let d = point - self.eye;
        Vec3::new(d.dot(&self.right), d.dot(&self.above), d.dot(&self.forward))
    }

    /// A point before the eye on the screen.
    pub(super) fn project(&self, local: Vec3) -> ScreenCorner {
        let near = 1.0 / local.z;
        ScreenCorner {
            x: self.centre[0] + self.focal * local.x * near,
            y: self.centre[1] - self.focal * local.y * near,
            near,
        }
    }

    /// The direction seen at the middle of a pixel, of unit length along `forward`.
    pub(super) fn ray(&self, x: usize, y: usize) -> Vec3 {
        self.ray_at((x as f64 + 0.5, y as f64 + 0.5))
    }

    /// The direction seen at a place of the screen, of unit length along `forward`.
    pub(super) fn ray_at(&self, (x, y): (f64, f64)) -> Vec3 {
        let right = (x - self.centre[0]) / self.focal;
        let above = (self.centre[1] - y) / self.focal;
        self.forward + self.right * right + self.above * above
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_a_projected_point_meets_it() {
        let camera =
            Camera::look((Vec3::new(3.0, -2.0, 1.0), Vec3::zeros()), Vec3::z(), 40.0, (640, 480));
        let point = Vec3::new(0.2, 0.3, -0.1);
        let local = camera.local(point);
        let seen = camera.project(local);
        let ray = camera.ray(seen.x as usize, seen.y as usize);
        let hit = camera.eye + ray * local.z;
        assert!((hit - point).norm() < 2.0 * local.z / camera.focal, "{hit}");
    }

    #[test]
    fn a_fitted_cube_fills_the_picture_and_stays_inside() {
        let corner = |i: u32| {
            Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0
        };
        let points: Vec<Vec3> = (0..8).map(corner).collect();
        let camera = Camera::fit(&points, Vec3::new(1.0, 0.6, -0.4), Vec3::z(), (480, 320));
        let mut reach = 0.0_f64;
        for point in points {
            let seen = camera.project(camera.local(point));
            assert!((0.0..480.0).contains(&seen.x) && (0.0..320.0).contains(&seen.y), "{seen:?}");
            reach = reach.max((seen.y - 160.0).abs() / 160.0);
        }
        assert!(reach > 0.6, "{reach}");
    }
}
