//! Where a crack that ends inside a body meets its surface: the line that one sees.

use cullet_geometry::inside::Nearest;
use cullet_geometry::{Sheet, TriMesh, Vec3};

/// A border of a sheet runs on a surface that is this near \[diagonals of the body\].
const ON: f64 = 1e-6;

/// A piece of such a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace {
    /// Its ends, in the body's frame \[m\].
    pub ends: [Vec3; 2],
    /// The unit normal of the surface there.
    pub normal: Vec3,
}

/// The lines that a sheet draws on the surface of a body.
pub fn traces(body: &TriMesh, sheet: &Sheet) -> Vec<Trace> {
    if sheet.is_empty() {
        return Vec::new();
    }
    let surface = Nearest::new(body);
    let near = ON * body.diagonal();
    let on: Vec<bool> = sheet.mesh.vertices.iter().map(|&p| surface.distance(p) <= near).collect();
    let border = sheet.mesh.open_edges().into_iter();
    let trace = |edge: [u32; 2]| {
        let ends = edge.map(|v| sheet.mesh.vertices[v as usize]);
        let (_, _, home) = surface.closest(0.5 * (ends[0] + ends[1]))?;
        let [a, b, c] = body.corners(home);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Trace { ends, normal })
    };
    border.filter(|edge| edge.iter().all(|&v| on[v as usize])).filter_map(trace).collect()
}

#[cfg(test)]
mod tests {
    use super::traces;
    use cullet_geometry::inside::Inside;
    use cullet_geometry::{Sheet, TriMesh, Vec3, shapes};

    #[test]
    fn a_crack_is_seen_where_it_meets_the_surface_and_not_where_it_ends() {
        let body = shapes::cuboid(Vec3::repeat(2.0), shapes::Detail::default()).expect("a box");
        // The plane x = 0.1, from beyond y = −1 to y = 0.2.
        let n = 20;
        let at = |i: u32| {
            Vec3::new(0.1, -1.3 + 1.5 * f64::from(i % n) / 19.0, {
                -1.3 + 2.6 * f64::from(i / n) / 19.0
            })
        };
        let quad = |k: u32| {
            let (i, j) = (k % (n - 1), k / (n - 1));
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * n + i);
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..(n - 1) * (n - 1)).flat_map(quad).collect();
        let mesh = TriMesh { vertices: (0..n * n).map(at).collect(), triangles };
        let marks = vec![0.0; mesh.vertices.len()];
        let sheet = Sheet { mesh, damage_time: marks.clone(), front_speed: marks };
        let sheet = sheet.clipped(&Inside::new(&body));
        let traces = traces(&body, &sheet);
        let length: f64 = traces.iter().map(|t| (t.ends[1] - t.ends[0]).norm()).sum();
        // Along y = −1 and up to y = 0.2 on both z faces; edges of the sheet cut corners.
        assert!((length - 4.4).abs() < 0.05, "{length}");
        assert!(traces.iter().all(|t| t.normal.x == 0.0 && t.normal.y < 0.5));
    }
}
