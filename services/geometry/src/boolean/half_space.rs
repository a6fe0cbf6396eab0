//! A box large enough to be a half space to a body.

use crate::math::Vec3;
use crate::mesh::{Solid, Surface, TriMesh};

/// A box on the side of the plane through `at` to which `normal` points, that covers every point
/// within `reach` of the middle of the body, whose nearest point of the plane is `at`.
pub(super) fn half_space(normal: Vec3, at: Vec3, reach: f64) -> Solid {
    let helper = if normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let u = normal.cross(&helper).normalize();
    let v = normal.cross(&u);
    // The plane is at most `reach` from the middle, the body at most `reach` beyond.
    let side = 3.0 * reach;
    let corner = |i: usize| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { side } else { -side };
        at + sign(0) * u + sign(1) * v + if i >> 2 == 1 { side } else { 0.0 } * normal
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> =
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let surface = vec![Surface::crack(0.0); triangles.len()];
    Solid { mesh: TriMesh { vertices: (0..8).map(corner).collect(), triangles }, surface }
}
