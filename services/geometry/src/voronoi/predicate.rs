//! Exact answers to: is the corner that four generators share nearer to a fifth?

use super::cells::Cells;
use crate::math::Vec3;
use robust::{Coord, Coord3D, insphere, orient2d, orient3d};

/// Positive where the corner shared by `site` and `planes` (in the order of a positive corner) is
/// nearer to site `other`, negative where it is not, zero in special position.
///
/// On a wall, an edge or a corner of the box the diagram is a power diagram of one dimension less,
/// whose weights are the squared distances to it: the test is the same one, lifted.
pub(super) fn nearer(cells: &Cells, site: u32, planes: [u32; 3], other: u32) -> f64 {
    let point = |id: u32| cells.sites[id as usize];
    let mut fixed: [Option<f64>; 3] = [None; 3];
    let mut mates: [Vec3; 3] = [Vec3::zeros(); 3];
    let mut count = 0;
    for id in planes {
        if let Some((axis, at)) = cells.wall(id) {
            fixed[axis] = Some(at);
        } else {
            mates[count] = point(id);
            count += 1;
        }
    }
    let (i, d) = (point(site), point(other));
    let free: Vec<usize> = (0..3).filter(|&k| fixed[k].is_none()).collect();
    // |p|² on the free axes plus the squared distance to the walls on the others.
    let lift =
        |p: Vec3| -> f64 { (0..3).map(|k| p[k] - fixed[k].unwrap_or(0.0)).map(|x| x * x).sum() };
    match (count, free.as_slice()) {
        (3, _) => insphere(c3(mates[0]), c3(mates[1]), c3(mates[2]), c3(i), c3(d)),
        (2, &[u, v]) => {
            let flat = |p: Vec3| Coord { x: p[u], y: p[v] };
            let up = |p: Vec3| Coord3D { x: p[u], y: p[v], z: lift(p) };
            let [a, b, _] = mates;
            orient3d(up(i), up(a), up(b), up(d)) * orient2d(flat(i), flat(a), flat(b)).signum()
        }
        (1, &[u]) => {
            let up = |p: Vec3| Coord { x: p[u], y: lift(p) };
            -orient2d(up(i), up(mates[0]), up(d)) * (mates[0][u] - i[u]).signum()
        }
        _ => lift(i) - lift(d),
    }
}

fn c3(p: Vec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}
