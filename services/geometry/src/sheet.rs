//! Open sheets: cracks that end inside a body and part nothing.

use crate::inside::Inside;
use crate::math::Vec3;
use crate::mesh::{MeshError, TriMesh, find, join};
use std::collections::BTreeMap;

/// Halvings in which the way out of a body is found: to 1e-9 of an edge.
const HALVINGS: usize = 30;

/// A crack surface with borders, and what is known of the front at each of its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// The surface; each edge belongs to one triangle (a border) or more.
    pub mesh: TriMesh,
    /// At each vertex: time from the impact to full damage \[s\].
    pub damage_time: Vec<f32>,
    /// At each vertex: how fast the front passed \[m/s\]; zero where it is not known.
    pub front_speed: Vec<f32>,
}

impl Sheet {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.mesh.triangles.is_empty()
    }

    /// Checks the arrays: finite vertices, indices in range, a time and a speed a vertex.
    ///
    /// # Errors
    /// The first thing found wrong.
    pub fn validate(&self) -> Result<(), MeshError> {
        self.mesh.validate()?;
        let vertices = self.mesh.vertices.len();
        for marks in [&self.damage_time, &self.front_speed] {
            if marks.len() != vertices {
                return Err(MeshError::Marks { marks: marks.len(), vertices });
            }
            let bad = |value: &f32| !(value.is_finite() && *value >= 0.0);
            if let Some(vertex) = marks.iter().position(bad) {
                return Err(MeshError::Mark { vertex, value: marks[vertex] });
            }
        }
        Ok(())
    }

    /// The sheet moved by `offset` \[m\].
    #[must_use]
    pub fn translated(&self, offset: Vec3) -> Self {
        Self { mesh: self.mesh.translated(offset), ..self.clone() }
    }

    /// What of it lies inside a body, to its surface. Triangles with all corners on one side are
    /// not divided.
    #[must_use]
    pub fn clipped(&self, body: &Inside) -> Self {
        let held: Vec<bool> = self.mesh.vertices.iter().map(|&p| body.contains(p)).collect();
        let mut whole = self.clone();
        whole.mesh.triangles.clear();
        let mut exits: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for corners in &self.mesh.triangles {
            let mut kept: Vec<u32> = Vec::with_capacity(4);
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let (from, to) = (held[a as usize], held[b as usize]);
                if from {
                    kept.push(a);
                }
                if from != to {
                    let ends = if from { [a, b] } else { [b, a] };
                    let exit = exits.entry(ends).or_insert_with(|| whole.exit(ends, body));
                    kept.push(*exit);
                }
            }
            for k in 2..kept.len() {
                whole.mesh.triangles.push([kept[0], kept[k - 1], kept[k]]);
            }
        }
        let all: Vec<usize> = (0..whole.mesh.triangles.len()).collect();
        whole.part(&all)
    }

    /// Adds the last point inside on the way from a vertex inside to one outside.
    fn exit(&mut self, [from, to]: [u32; 2], body: &Inside) -> u32 {
        let (from, to) = (from as usize, to as usize);
        let (p, way) =
            (self.mesh.vertices[from], self.mesh.vertices[to] - self.mesh.vertices[from]);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if body.contains(p + middle * way) { &mut low } else { &mut high }) = middle;
        }
        self.mesh.vertices.push(p + low * way);
        for marks in [&mut self.damage_time, &mut self.front_speed] {
            let (a, b) = (f64::from(marks[from]), f64::from(marks[to]));
            marks.push((a + low * (b - a)) as f32);
        }
        self.mesh.vertices.len() as u32 - 1
    }

    /// The sheet of some of its triangles, with only the vertices that they use.
    #[must_use]
    pub fn part(&self, triangles: &[usize]) -> Self {
        let mut used: Vec<u32> = triangles.iter().flat_map(|&t| self.mesh.triangles[t]).collect();
        used.sort_unstable();
        used.dedup();
        let local = |i: u32| used.partition_point(|&other| other < i) as u32;
        let triangles = triangles.iter().map(|&t| self.mesh.triangles[t].map(local)).collect();
        let of = |marks: &[f32]| used.iter().map(|&v| marks[v as usize]).collect();
        let vertices = used.iter().map(|&v| self.mesh.vertices[v as usize]).collect();
        Self {
            mesh: TriMesh { vertices, triangles },
            damage_time: of(&self.damage_time),
            front_speed: of(&self.front_speed),
        }
    }

    /// Adds another sheet; nothing is welded.
    pub fn append(&mut self, other: &Self) {
        self.mesh.append(&other.mesh);
        self.damage_time.extend(&other.damage_time);
        self.front_speed.extend(&other.front_speed);
    }

    /// Its parts without junctions: triangles that hang together over edges that two of them use,
    /// all facing one way. A part that cannot (a Möbius strip) is left facing as it may.
    #[must_use]
    pub fn leaves(&self) -> Vec<Self> {
        let mut edges: Vec<([u32; 2], bool, u32)> = Vec::new();
        for (t, &[a, b, c]) in (0u32..).zip(&self.mesh.triangles) {
            edges.extend([(a, b), (b, c), (c, a)].map(|(a, b)| ([a.min(b), a.max(b)], a < b, t)));
        }
        edges.sort_unstable();
        let pairs: Vec<&[([u32; 2], bool, u32)]> =
            edges.chunk_by(|x, y| x.0 == y.0).filter(|uses| uses.len() == 2).collect();
        let count = self.mesh.triangles.len();
        let mut root: Vec<u32> = (0..count as u32).collect();
        let mut beside: Vec<Vec<(u32, bool)>> = vec![Vec::new(); count];
        for pair in pairs {
            let (s, t, turned) = (pair[0].2, pair[1].2, pair[0].1 == pair[1].1);
            join(&mut root, s, t);
            beside[s as usize].push((t, turned));
            beside[t as usize].push((s, turned));
        }
        let mut flip = vec![None; count];
        for start in 0..count {
            let mut stack = vec![(start, false)];
            while let Some((t, turn)) = stack.pop() {
                if flip[t].is_none() {
                    flip[t] = Some(turn);
                    stack.extend(beside[t].iter().map(|&(s, turned)| (s as usize, turn ^ turned)));
                }
            }
        }
        let mut facing = self.clone();
        for (corners, flip) in facing.mesh.triangles.iter_mut().zip(&flip) {
            if *flip == Some(true) {
                corners.swap(1, 2);
            }
        }
        let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for t in 0..count {
            groups.entry(find(&mut root, t as u32)).or_default().push(t);
        }
        groups.values().map(|group| facing.part(group)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Sheet;
    use crate::inside::Inside;
    use crate::math::Vec3;
    use crate::mesh::TriMesh;
    use crate::shapes;

    /// A square of n × n quads in the plane z = 0, of size 2 about the origin.
    fn square(n: u32) -> Sheet {
        let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
        let corner = |i: u32, j: u32| j * (n + 1) + i;
        let places = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
        let vertices: Vec<Vec3> = places.map(|(i, j)| Vec3::new(at(i), at(j), 0.0)).collect();
        let quad = |(i, j)| {
            let [a, b, c, d] =
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            // Every other quad faces down.
            if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] }
        };
        let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let triangles = cells.flat_map(quad).collect();
        let damage_time = vertices.iter().map(|p| (p.x + 1.0) as f32).collect();
        let front_speed = vec![3.0; vertices.len()];
        Sheet { mesh: TriMesh { vertices, triangles }, damage_time, front_speed }
    }

    #[test]
    fn a_clipped_sheet_ends_at_the_surface() {
        let ball = shapes::sphere(0.8, shapes::Detail::default()).unwrap();
        let body = Inside::new(&ball);
        let sheet = square(40).clipped(&body);
        sheet.validate().unwrap();
        let disc = std::f64::consts::PI * 0.64;
        assert!((sheet.mesh.area() / disc - 1.0).abs() < 0.01, "{}", sheet.mesh.area());
        assert!(sheet.mesh.vertices.iter().all(|&p| p.norm() < 0.8 + 1e-9));
        for edge in sheet.mesh.open_edges() {
            let far = edge.map(|v| sheet.mesh.vertices[v as usize].norm());
            assert!(far.iter().all(|r| *r > 0.79), "a border inside: {far:?}");
        }
        for (p, time) in sheet.mesh.vertices.iter().zip(&sheet.damage_time) {
            assert!((f64::from(*time) - p.x - 1.0).abs() < 1e-6);
        }
        assert!(square(4).translated(Vec3::z()).clipped(&body).is_empty());
    }

    #[test]
    fn leaves_face_one_way_and_part_at_junctions() {
        let leaves = square(6).leaves();
        assert_eq!(leaves.len(), 1);
        assert_eq!(leaves[0].mesh.triangles.len(), 72);
        let up = |mesh: &TriMesh, t: usize| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(&(c - a)).z > 0.0
        };
        assert!((0..72).all(|t| up(&leaves[0].mesh, t) == up(&leaves[0].mesh, 0)));
        // A third leaf at the line x = 0.
        let mut three = square(6);
        let fin = [[3, 10, 49], [10, 50, 49]];
        three.mesh.vertices.extend([Vec3::new(0.0, -1.0, 1.0), Vec3::new(0.0, -0.5, 1.0)]);
        three.mesh.triangles.extend(fin);
        three.damage_time.extend([0.0; 2]);
        three.front_speed.extend([0.0; 2]);
        let leaves = three.leaves();
        // Only the edge that three use parts; the two halves hang together beyond it.
        let counts: Vec<usize> = leaves.iter().map(|leaf| leaf.mesh.triangles.len()).collect();
        assert_eq!(counts, [72, 2]);
    }
}
