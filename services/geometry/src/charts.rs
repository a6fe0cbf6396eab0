//! Flat charts of crack faces: texture coordinates in metres.

use crate::math::Vec3;
use crate::mesh::{Solid, Surface};
use std::collections::VecDeque;

/// A face joins a chart while its normal is within this of the chart's mean normal: cosine of 55°.
/// Lengths in a chart are then true across the slope, and down to cos 55° of true along it.
const SLOPE: f64 = 0.574;

/// The plane of a chart: a point p has u = p·`u`, v = p·`v` \[m\], from the body's own origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// Unit axis of u.
    pub u: Vec3,
    /// Unit axis of v; `u × v` is the mean normal of its faces.
    pub v: Vec3,
}

/// Divides the crack faces of a solid into connected charts of one parent and about one direction.
/// Returns the chart of each crack face, in order, and the charts. Crack faces that lie in one
/// plane share their axes, so a texture runs on over them.
#[must_use]
pub fn charts(solid: &Solid) -> (Vec<u32>, Vec<Chart>) {
    let faces = Faces::new(solid);
    let mut chart = vec![u32::MAX; solid.surface.len()];
    let mut charts = Vec::new();
    for start in (0..chart.len()).filter(|&t| solid.surface[t].is_crack()) {
        if chart[start] != u32::MAX {
            continue;
        }
        let name = charts.len() as u32;
        let mut sum = faces.smooth[start];
        let mut queue = VecDeque::from([start]);
        chart[start] = name;
        while let Some(t) = queue.pop_front() {
            for &s in &faces.beside[t] {
                let alike = faces.parent(s) == faces.parent(t);
                let flat = faces.smooth[s].dot(&sum) > SLOPE * faces.smooth[s].norm() * sum.norm();
                if chart[s] == u32::MAX && alike && flat {
                    chart[s] = name;
                    sum += faces.smooth[s];
                    queue.push_back(s);
                }
            }
        }
        charts.push(axes(sum));
    }
    let cracks = chart.into_iter().zip(&solid.surface).filter(|(_, s)| s.is_crack());
    (cracks.map(|(chart, _)| chart).collect(), charts)
}

/// Crack faces and their neighbours.
struct Faces<'a> {
    solid: &'a Solid,
    /// Area vectors, with those of the neighbours: relief does not tear charts.
    smooth: Vec<Vec3>,
    beside: Vec<Vec<usize>>,
}

impl<'a> Faces<'a> {
    fn new(solid: &'a Solid) -> Self {
        let mesh = &solid.mesh;
        let mut edges: Vec<([u32; 2], usize)> = Vec::new();
        for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            if solid.surface[t].is_crack() {
                edges.extend([(a, b), (b, c), (c, a)].map(|(a, b)| ([a.min(b), a.max(b)], t)));
            }
        }
        edges.sort_unstable();
        let mut beside = vec![Vec::new(); mesh.triangles.len()];
        for pair in edges.chunk_by(|x, y| x.0 == y.0).filter(|pair| pair.len() == 2) {
            beside[pair[0].1].push(pair[1].1);
            beside[pair[1].1].push(pair[0].1);
        }
        let area = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(&(c - a))
        };
        let mut smooth: Vec<Vec3> = (0..mesh.triangles.len()).map(area).collect();
        for _ in 0..2 {
            let old = smooth.clone();
            for (t, others) in beside.iter().enumerate() {
                // A neighbour across an edge is not smoothed with.
                let level =
                    |s: &&usize| 2.0 * old[**s].dot(&old[t]) > old[**s].norm() * old[t].norm();
                smooth[t] += others.iter().filter(level).map(|&s| old[s]).sum::<Vec3>();
            }
        }
        Self { solid, smooth, beside }
    }

    fn parent(&self, t: usize) -> u32 {
        match self.solid.surface[t] {
            Surface::Outer => 0,
            Surface::Crack { parent, .. } => parent,
        }
    }
}

/// Axes of the plane across `normal`, the same for the same normal.
fn axes(normal: Vec3) -> Chart {
    let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::z);
    let axis = if normal.z.abs() < 0.9 { Vec3::z() } else { Vec3::x() };
    let u = axis.cross(&normal).normalize();
    Chart { u, v: normal.cross(&u) }
}

#[cfg(test)]
mod tests {
    use super::charts;
    use crate::math::Vec3;
    use crate::mesh::{Solid, Surface};
    use crate::shapes;

    #[test]
    fn a_flat_chart_measures_in_metres() {
        let mut solid =
            Solid::outer(shapes::cuboid(Vec3::new(1.0, 2.0, 3.0), Default::default()).unwrap());
        let top = |t: usize| {
            let [a, b, c] = solid.mesh.corners(t);
            (b - a).cross(&(c - a)).normalize().z > 0.5 || (b - a).cross(&(c - a)).x > 1e-9
        };
        let cracked: Vec<usize> = (0..solid.mesh.triangles.len()).filter(|&t| top(t)).collect();
        cracked.iter().for_each(|&t| solid.surface[t] = Surface::crack(0.0));
        let (of, charts) = charts(&solid);
        // Two sides that meet at a right angle: two charts.
        assert_eq!((of.len(), charts.len()), (cracked.len(), 2));
        for (&t, &chart) in cracked.iter().zip(&of) {
            let chart = charts[chart as usize];
            let corners = solid.mesh.corners(t);
            for k in 0..3 {
                let edge = corners[(k + 1) % 3] - corners[k];
                let (u, v) = (edge.dot(&chart.u), edge.dot(&chart.v));
                assert!((u * u + v * v - edge.norm_squared()).abs() < 1e-12);
            }
        }
    }
}
