//! Normals at the corners of triangles.

use cullet_geometry::Vec3;

/// Faces that meet at less than this are shaded as one curved surface: cosine of 40°.
const CREASE: f64 = 0.766;

/// The unit normal at each corner of each triangle: the mean of those around it that turn by less
/// than a crease does, and that are `alike`.
pub(super) fn corner_normals(
    vertices: &[Vec3],
    triangles: &[[u32; 3]],
    alike: impl Fn(usize, usize) -> bool,
) -> Vec<[Vec3; 3]> {
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| vertices[v as usize]);
        (b - a).cross(&(c - a))
    };
    let area_normals: Vec<Vec3> = triangles.iter().map(area).collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); vertices.len()];
    for (t, corners) in (0u32..).zip(triangles) {
        corners.iter().for_each(|&v| around[v as usize].push(t));
    }
    let unit = |n: &Vec3| n.try_normalize(1e-300).unwrap_or_else(Vec3::zeros);
    let normal = |t: usize, v: u32| {
        let own = unit(&area_normals[t]);
        let near = around[v as usize].iter().filter(|&&other| {
            let other = other as usize;
            alike(t, other) && unit(&area_normals[other]).dot(&own) > CREASE
        });
        unit(&near.map(|&other| area_normals[other as usize]).sum::<Vec3>())
    };
    triangles.iter().enumerate().map(|(t, c)| c.map(|v| normal(t, v))).collect()
}
