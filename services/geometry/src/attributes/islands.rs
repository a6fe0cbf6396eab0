//! Connected parts of a surface over which its texture coordinates are continuous.

use super::SurfaceAttributes;

/// An edge of a triangle: its vertices, and the bits of the texture coordinates there.
type Seam = ([u32; 2], [[u32; 2]; 2]);

/// The island of each triangle, named by the first triangle of it. Two triangles are of one island
/// if they share an edge, the texture coordinates at its ends, the material and the object.
pub(super) fn islands(surface: &SurfaceAttributes) -> Vec<u32> {
    let count = surface.mesh.triangles.len();
    let mut edges: Vec<((Seam, [u32; 2]), u32)> = Vec::with_capacity(3 * count);
    for (t, corners) in surface.mesh.triangles.iter().enumerate() {
        let uv = surface.uv.get(t).map_or([[0; 2]; 3], |uv| uv.map(|c| c.map(bits)));
        let look = [surface.slot_of(t), surface.object_of(t)];
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (i, j) = if corners[i] < corners[j] { (i, j) } else { (j, i) };
            let seam = ([corners[i], corners[j]], [uv[i], uv[j]]);
            edges.push(((seam, look), t as u32));
        }
    }
    edges.sort_unstable();
    let mut parents: Vec<u32> = (0..count as u32).collect();
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (a, b) = (root(&mut parents, pair[0].1), root(&mut parents, pair[1].1));
        parents[a.max(b) as usize] = a.min(b);
    }
    (0..count as u32).map(|t| root(&mut parents, t)).collect()
}

/// Zero of either sign has the same bits.
fn bits(coordinate: f32) -> u32 {
    (coordinate + 0.0).to_bits()
}

fn root(parents: &mut [u32], mut t: u32) -> u32 {
    while parents[t as usize] != t {
        let above = parents[parents[t as usize] as usize];
        parents[t as usize] = above;
        t = above;
    }
    t
}
