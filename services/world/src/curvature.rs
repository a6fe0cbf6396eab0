//! The radius of a surface where it is touched: from the mesh near the point, not from the distance
//! to the centre (F40).

use cullet_geometry::{TriMesh, Vec3};

/// The surface that counts reaches this share of the body's size from the point.
const WINDOW: f64 = 0.4;
/// Corners and edges are no sharper than this share of the size.
const SHARPEST: f64 = 0.01;
/// Faces are no flatter than this many sizes.
const FLATTEST: f64 = 10.0;
/// Triangles are looked at in pieces no longer than this share of the window.
const GRAIN: f64 = 0.3;
/// Halvings of a triangle at most: bounds the work on huge faces.
const DEEPEST: u32 = 16;
/// Faces that turn further away than this from the contact normal belong to another side of a wall.
const FACING: f64 = 0.2;

/// Radius of curvature \[m\] at `point` with outward direction `outward`, for a body that reaches
/// `size` \[m\].
///
/// Fits the paraboloid h = r²/2R by area-weighted least squares: 1/R = 2 Σ h r² / Σ r⁴, with h the
/// depth below the tangent plane and r the distance from the axis.
pub(crate) fn radius(mesh: &TriMesh, point: &Vec3, outward: &Vec3, size: f64) -> f64 {
    let mut fit =
        Fit { point: *point, outward: *outward, window: WINDOW * size, depth: 0.0, spread: 0.0 };
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        if normal.dot(outward) > FACING * normal.norm() {
            fit.add(corners, DEEPEST);
        }
    }
    let (least, most) = (SHARPEST * size, FLATTEST * size);
    if fit.depth * most <= 0.5 * fit.spread {
        most
    } else {
        (0.5 * fit.spread / fit.depth).clamp(least, most)
    }
}

struct Fit {
    point: Vec3,
    outward: Vec3,
    window: f64,
    /// Σ area h r².
    depth: f64,
    /// Σ area r⁴.
    spread: f64,
}

impl Fit {
    fn add(&mut self, corner: [Vec3; 3], deeper: u32) {
        let middle = (corner[0] + corner[1] + corner[2]) / 3.0;
        let reach = corner.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        if (middle - self.point).norm() > self.window + reach {
            return;
        }
        if reach > GRAIN * self.window && deeper > 0 {
            let (a, b, c) = longest_first(corner);
            let half = (a + b) / 2.0;
            self.add([a, half, c], deeper - 1);
            self.add([half, b, c], deeper - 1);
            return;
        }
        let from = middle - self.point;
        let h = -from.dot(&self.outward);
        let r2 = (from + self.outward * h).norm_squared();
        if r2 + h * h > self.window * self.window {
            return;
        }
        let area = 0.5 * (corner[1] - corner[0]).cross(&(corner[2] - corner[0])).norm();
        self.depth += area * h.max(0.0) * r2;
        self.spread += area * r2 * r2;
    }
}

/// The same triangle, turned so that its longest edge comes first.
fn longest_first([a, b, c]: [Vec3; 3]) -> (Vec3, Vec3, Vec3) {
    let (ab, bc, ca) = ((b - a).norm(), (c - b).norm(), (a - c).norm());
    if ab >= bc && ab >= ca {
        (a, b, c)
    } else if bc >= ca {
        (b, c, a)
    } else {
        (c, a, b)
    }
}

/// The point of the surface nearest to `point` \[m\].
pub(crate) fn nearest(mesh: &TriMesh, point: &Vec3) -> Vec3 {
    let mut best = (f64::INFINITY, *point);
    for t in 0..mesh.triangles.len() {
        let candidate = nearest_on(mesh.corners(t), point);
        let distance = (candidate - point).norm_squared();
        if distance < best.0 {
            best = (distance, candidate);
        }
    }
    best.1
}

/// The point of a triangle nearest to `p` (Voronoi regions of corners, edges, face).
fn nearest_on([a, b, c]: [Vec3; 3], p: &Vec3) -> Vec3 {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let n = ab.cross(&ac);
    let inside = |from: &Vec3, edge: &Vec3| n.dot(&edge.cross(&(p - from))) >= 0.0;
    if n.norm_squared() > 0.0 && inside(&a, &ab) && inside(&b, &bc) && inside(&c, &-ac) {
        return p - n * (n.dot(&(p - a)) / n.norm_squared());
    }
    let on = |from: Vec3, edge: Vec3| {
        let length = edge.norm_squared();
        let s = if length > 0.0 { (edge.dot(&(p - from)) / length).clamp(0.0, 1.0) } else { 0.0 };
        from + edge * s
    };
    let candidates = [on(a, ab), on(b, bc), on(a, ac)];
    let far = |q: &Vec3| (q - p).norm_squared();
    candidates
        .into_iter()
        .fold(candidates[0], |best, q| if far(&q) < far(&best) { q } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of radius 1 from latitude rings.
    fn sphere(rings: u32, slices: u32) -> TriMesh {
        let mut mesh = TriMesh::default();
        let pi = std::f64::consts::PI;
        for i in 0..=rings {
            for j in 0..slices {
                let (st, ct) = libm::sincos(pi * f64::from(i) / f64::from(rings));
                let (sp, cp) = libm::sincos(2.0 * pi * f64::from(j) / f64::from(slices));
                mesh.vertices.push(Vec3::new(st * cp, st * sp, ct));
            }
        }
        for i in 0..rings {
            for j in 0..slices {
                let at = |i: u32, j: u32| i * slices + j % slices;
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        mesh
    }

    #[test]
    fn a_sphere_has_its_radius_everywhere() {
        let mesh = sphere(40, 64);
        for n in [Vec3::x(), Vec3::new(0.6, 0.0, 0.8), Vec3::new(1.0, 2.0, -3.0).normalize()] {
            let r = radius(&mesh, &nearest(&mesh, &(n * 1.5)), &n, 1.0);
            assert!((r - 1.0).abs() < 0.08, "radius {r} at {n}");
        }
    }

    #[test]
    fn a_face_is_flat_and_a_corner_is_sharp_whatever_the_distance_to_the_centre() {
        let triangle = |s: f64, z: f64| TriMesh {
            vertices: vec![Vec3::new(-s, -s, z), Vec3::new(s, -s, z), Vec3::new(0.0, s, z)],
            triangles: vec![[0, 1, 2]],
        };
        let flat = radius(&triangle(5.0, 1.0), &Vec3::new(0.0, 0.0, 1.0), &Vec3::z(), 1.0);
        assert_eq!(flat, FLATTEST);
        // A cone with a half-angle of 45°.
        let mut cone = TriMesh::default();
        cone.vertices.push(Vec3::zeros());
        for j in 0..24u32 {
            let (s, c) = libm::sincos(f64::from(j) * std::f64::consts::PI / 12.0);
            cone.vertices.push(Vec3::new(c, s, -1.0));
            cone.triangles.push([0, 1 + j, 1 + (j + 1) % 24]);
        }
        let sharp = radius(&cone, &Vec3::zeros(), &Vec3::z(), 1.0);
        assert!(sharp < 0.15, "corner radius {sharp}");
    }
}
