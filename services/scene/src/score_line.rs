//! From a line that a scene scores on a body to the grooves that travel with a job.

use super::context::ResolveContext;
use super::geometry::BodyGeometry;
use cullet_document::check::tell;
use cullet_document::tree::{Path, join};
use cullet_geometry::Vec3;
use cullet_geometry::inside::Nearest;
use cullet_model::strength::{Region, Stroke};

/// A point of a line may lie this share of the body's diagonal off its surface \[1\].
const OFF: f64 = 0.02;
/// A segment is divided to pieces of at most this share of the body's diagonal, so that the line
/// follows a curved surface \[1\].
const LONGEST: f64 = 0.05;
/// A ray that looks for the other side of a wall begins this share of the diagonal below the
/// surface \[1\].
const BELOW: f64 = 1e-6;
/// Faces whose normals have a greater product are one \[1\].
const SAME_FACE: f64 = 0.7;

/// A line as it is written.
pub(super) struct ScoreLine<'a> {
    pub(super) points: &'a [[f64; 3]],
    pub(super) width: Option<f64>,
    pub(super) depth: Option<f64>,
    pub(super) factor: f64,
}

impl ScoreLine<'_> {
    /// Its grooves, in the frame of the pattern; what is wrong is noted.
    pub(super) fn grooves(
        &self,
        context: &mut ResolveContext<'_>,
        geometry: &BodyGeometry,
        path: &Path,
    ) -> Vec<Stroke> {
        let path = join(path, "points");
        if self.points.len() < 2 {
            context.wrong(
                &path,
                format!("a line has two points or more; it has {}", self.points.len()),
            );
            return Vec::new();
        }
        let surface = Nearest::new(&geometry.solid.mesh);
        let size = geometry.solid.mesh.diagonal();
        let corners: Vec<Vec3> =
            self.points.iter().map(|point| Vec3::from(*point) + geometry.origin).collect();
        for (index, corner) in corners.iter().enumerate() {
            let (off, most) = (surface.distance(*corner), OFF * size);
            if off > most {
                let message =
                    format!("lies {} m off the surface; at most {} m", tell(off), tell(most));
                context.wrong(&join(&path, index), message);
            }
        }
        if let Some(index) = corners.windows(2).position(|ends| ends[0] == ends[1]) {
            context.wrong(&join(&path, index + 1), "must differ from the point before it");
            return Vec::new();
        }
        let on = |point: Vec3| surface.closest(point).map(|(place, ..)| place);
        let mut places: Vec<Vec3> = Vec::new();
        for ends in corners.windows(2) {
            let way = ends[1] - ends[0];
            let count = (way.norm() / (LONGEST * size)).ceil().max(1.0) as usize;
            places.extend((0..count).filter_map(|k| on(ends[0] + way * (k as f64 / count as f64))));
        }
        places.extend(corners.last().and_then(|last| on(*last)));
        places.dedup();
        let groove = |ends: &[Vec3]| {
            let (from, to) = (ends[0], ends[1]);
            // An end may lie on an edge of the body, where there is no one way into it.
            let axis = (to - from).normalize();
            let inward = self.inward(&surface, 0.5 * (from + to), axis, size)?;
            let (from, to) = (from - geometry.origin, to - geometry.origin);
            let half_width = 0.5 * self.width.unwrap_or(0.0);
            let region = Region::Groove { from, to, inward, half_width };
            Some(Stroke { region, factor: self.factor, edge: 0.0 })
        };
        places.windows(2).filter_map(groove).collect()
    }

    /// The way from the surface at a point to the bottom of the groove of that direction: as deep
    /// as is written, or through the wall. Along an edge of the body, where two faces meet, the
    /// face below which the wall is thinner.
    fn inward(&self, surface: &Nearest, point: Vec3, axis: Vec3, size: f64) -> Option<Vec3> {
        let (on, off, triangle) = surface.closest(point)?;
        let face = surface.normal(triangle)?;
        let other = surface
            .closest_of(point, |t| surface.normal(t).is_some_and(|n| n.dot(&face) < SAME_FACE))
            .filter(|(_, distance, _)| distance - off < BELOW * size)
            .and_then(|(_, _, t)| surface.normal(t));
        let below = |normal: Vec3| -> Option<(Vec3, f64)> {
            let down = (axis * axis.dot(&normal) - normal).try_normalize(0.0)?;
            let start = on - (face + other.unwrap_or_default()) * (BELOW * size);
            let hit = surface.first_hit(start, down, |_| true);
            Some((down, hit.map_or(size, |(distance, _)| distance + BELOW * size)))
        };
        let walls = std::iter::once(face).chain(other).filter_map(below);
        let (down, wall) = walls.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(down * self.depth.unwrap_or(wall))
    }
}
