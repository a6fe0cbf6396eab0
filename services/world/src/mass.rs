//! The few lengths, areas and levers that the world asks of a solid.

use cullet_geometry::{Mat3, TriMesh, Vec3};

/// Inertia of a point mass at `r` per unit mass \[m²\].
pub(crate) fn lever(r: &Vec3) -> Mat3 {
    Mat3::identity() * r.norm_squared() - r * r.transpose()
}

/// Greatest distance of a corner from the origin \[m\].
pub(crate) fn reach(mesh: &TriMesh) -> f64 {
    mesh.vertices.iter().map(Vec3::norm).fold(0.0, f64::max)
}

/// Rounding of a solid's volume, centre and inertia, over what they are \[1\]: they are sums over
/// tetrahedra on the middle, each right to a rounding of the reach cubed. The thinner a solid, the
/// more of it cancels.
pub(crate) fn rounding(mesh: &TriMesh, volume: f64, reach: f64) -> f64 {
    let count = mesh.triangles.len() as f64;
    8.0 * f64::EPSILON * count.sqrt() * (reach * reach * reach / volume)
}

/// Least moment of inertia over the greatest \[1\]: that of a wire 70 000 times as long as thick.
const LEAST_MOMENT: f64 = 1e-10;

/// The inertia with no moment below what a wire has, so that nothing spins up for nothing about the
/// line of a needle; `None` where a moment is negative by more than `noise`.
pub(crate) fn sound_inertia(inertia: &Mat3, noise: f64) -> Option<Mat3> {
    let moments = inertia.symmetric_eigenvalues();
    let least = LEAST_MOMENT * moments.max();
    if least > 0.0 && moments.min() >= least {
        return Some(*inertia);
    }
    if !(least > 0.0 && moments.min() > -noise) {
        return None;
    }
    let eigen = inertia.symmetric_eigen();
    let (axes, moments) = (eigen.eigenvectors, eigen.eigenvalues.map(|one| one.max(least)));
    Some(axes * Mat3::from_diagonal(&moments) * axes.transpose())
}

/// Extents of the box along the axes \[m\].
pub(crate) fn extents<'a>(points: impl Iterator<Item = &'a Vec3>) -> Vec3 {
    let far = f64::INFINITY;
    let (low, high) = points
        .fold((Vec3::repeat(far), Vec3::repeat(-far)), |(low, high), p| (low.inf(p), high.sup(p)));
    high - low
}

/// Area that the plane `n·x = offset` cuts out of a closed mesh \[m²\]: ½ Σ (p × q)·n over its
/// chords.
pub(crate) fn section(mesh: &TriMesh, n: &Vec3, offset: f64) -> f64 {
    let mut twice = 0.0;
    for t in 0..mesh.triangles.len() {
        let corner = mesh.corners(t);
        let height = corner.map(|p| n.dot(&p) - offset);
        let (mut into, mut out) = (None, None);
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            if (height[i] >= 0.0) == (height[j] >= 0.0) {
                continue;
            }
            let p = corner[i] + (corner[j] - corner[i]) * (height[i] / (height[i] - height[j]));
            if height[i] >= 0.0 {
                into = Some(p);
            } else {
                out = Some(p);
            }
        }
        if let (Some(p), Some(q)) = (into, out) {
            twice += p.cross(&q).dot(n);
        }
    }
    0.5 * twice.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuboid(size: Vec3, at: Vec3) -> TriMesh {
        let vertices = (0..8u32)
            .map(|i| {
                let s = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
                at + Vec3::new(s(0) * size.x, s(1) * size.y, s(2) * size.z)
            })
            .collect();
        let triangles = vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        TriMesh { vertices, triangles }
    }

    #[test]
    fn a_plane_cuts_the_right_area_out_of_a_cuboid() {
        let mesh = cuboid(Vec3::new(1.0, 2.0, 3.0), Vec3::zeros());
        assert!((section(&mesh, &Vec3::z(), 0.3) - 2.0).abs() < 1e-12);
        assert!((section(&mesh, &Vec3::x(), -0.2) - 6.0).abs() < 1e-12);
        assert!(section(&mesh, &Vec3::x(), 0.7) == 0.0);
    }
}
