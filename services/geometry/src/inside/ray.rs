//! Where a ray first meets a surface.

use super::nearest::{Nearest, OPEN_NODES};
use crate::math::Vec3;

impl Nearest {
    /// The distance \[m\] along the unit vector `way` from `origin` \[m\] at which a ray first
    /// meets one of the triangles that `of` takes, and that triangle. Not watertight: a ray along
    /// an edge may miss both its triangles.
    #[must_use]
    pub fn first_hit(
        &self,
        origin: Vec3,
        way: Vec3,
        of: impl Fn(usize) -> bool,
    ) -> Option<(f64, usize)> {
        let inverse = way.map(|c| 1.0 / c);
        let mut best: Option<(f64, usize)> = None;
        let mut stack: Vec<(u32, f64)> = Vec::with_capacity(OPEN_NODES);
        if let Some(entry) = self.nodes.first().and_then(|root| root.entry(origin, inverse)) {
            stack.push((0, entry));
        }
        while let Some((at, entry)) = stack.pop() {
            if best.is_some_and(|(distance, _)| entry > distance) {
                continue;
            }
            let node = self.nodes[at as usize];
            if node.second == 0 {
                for &t in &self.order[node.start as usize..node.end as usize] {
                    let hit = meets(origin, way, self.corners[t as usize]);
                    if let Some(distance) = hit
                        && best.is_none_or(|(least, _)| distance < least)
                        && of(t as usize)
                    {
                        best = Some((distance, t as usize));
                    }
                }
                continue;
            }
            let children = [at + 1, node.second];
            let mut entries = children.map(|child| {
                (child, self.nodes[child as usize].entry(origin, inverse).unwrap_or(f64::INFINITY))
            });
            if entries[0].1 < entries[1].1 {
                entries.swap(0, 1);
            }
            stack.extend(entries.into_iter().filter(|(_, entry)| entry.is_finite()));
        }
        best
    }
}

/// The distance along the unit vector `way` at which a ray meets a triangle \[m\] \[Möller &
/// Trumbore 1997\].
fn meets(origin: Vec3, way: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f64> {
    let (e, f) = (b - a, c - a);
    let p = way.cross(&f);
    let determinant = e.dot(&p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(&p) / determinant;
    let q = s.cross(&e);
    let v = way.dot(&q) / determinant;
    let distance = f.dot(&q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}
