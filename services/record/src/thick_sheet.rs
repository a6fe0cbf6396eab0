//! A sheet with both of its faces: each point twice, half a thickness to either side along the
//! normal, and side walls along rims and tears, so that its surface is closed.

use cullet_geometry::Vec3;
use cullet_model::MovingSurface;

/// A vertex of a [`ThickSheet`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThickVertex {
    /// The point of the surface that it belongs to.
    pub point: u32,
    /// On which side of that it lies: above, below, or, of a surface that is closed by itself, in
    /// it.
    pub side: SheetSide,
    /// Whether it is a corner of side walls.
    pub wall: bool,
    /// Which of the triangles' corners meet there.
    fan: u32,
}

/// A side of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SheetSide {
    /// From where its triangles run counter-clockwise.
    Above,
    /// The other one.
    Below,
    /// Neither.
    Within,
}

impl SheetSide {
    /// 1, −1 and 0.
    fn sign(self) -> f64 {
        match self {
            Self::Above => 1.0,
            Self::Below => -1.0,
            Self::Within => 0.0,
        }
    }
}

/// The faces of a sheet, whatever its points' places.
#[derive(Clone, Debug, PartialEq)]
pub struct ThickSheet {
    /// Corners, counter-clockwise seen from outside, of both faces and then of the walls.
    pub triangles: Vec<[u32; 3]>,
    /// What is known of each vertex. Walls have vertices of their own, for their normals.
    pub vertices: Vec<ThickVertex>,
    /// Thickness \[m\]; 0 for a surface that is closed by itself, and has each point once.
    pub thickness: f64,
    /// Corners of the surface between the faces, by their fans.
    middle: Vec<[u32; 3]>,
    /// The point of each fan.
    points: Vec<u32>,
    /// Edges of fans without a neighbour, and the triangle that each is of.
    rims: Vec<([u32; 2], u32)>,
}

/// Where the vertices of a [`ThickSheet`] are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlacedSheet {
    /// Place of each vertex \[m\].
    pub places: Vec<Vec3>,
    /// Unit normal of each, outward.
    pub normals: Vec<Vec3>,
}

impl ThickSheet {
    /// The faces of a surface.
    #[must_use]
    pub fn of(surface: &MovingSurface) -> Self {
        let thickness = f64::from(surface.thickness.max(0.0));
        Self::new(&surface.triangles, thickness)
    }

    fn new(triangles: &[[u32; 3]], thickness: f64) -> Self {
        let neighbours = neighbours(triangles);
        let (middle, points) = fans(triangles, &neighbours);
        let rims = (0u32..).zip(&neighbours).flat_map(|(t, of)| {
            let [a, b, c] = middle[t as usize];
            let edges = [[a, b], [b, c], [c, a]].into_iter().zip(of);
            edges.filter(|(_, other)| other.is_none()).map(move |(edge, _)| (edge, t))
        });
        let rims: Vec<([u32; 2], u32)> = rims.collect();
        let mut sheet = Self {
            triangles: middle.clone(),
            vertices: Vec::new(),
            thickness,
            middle,
            points,
            rims,
        };
        if thickness > 0.0 {
            sheet.close();
        } else {
            sheet.layer(SheetSide::Within);
        }
        sheet
    }

    /// Adds a vertex for each fan.
    fn layer(&mut self, side: SheetSide) {
        let vertex = |(fan, &point)| ThickVertex { point, side, wall: false, fan };
        self.vertices.extend((0u32..).zip(&self.points).map(vertex));
    }

    /// Adds the face below and the walls.
    fn close(&mut self) {
        let count = self.points.len() as u32;
        self.layer(SheetSide::Above);
        self.layer(SheetSide::Below);
        let below = self.middle.iter().map(|&[a, b, c]| [a + count, c + count, b + count]);
        self.triangles.extend(below);
        let mut wall: Vec<Option<u32>> = vec![None; self.points.len()];
        for ([from, to], _) in &self.rims {
            for &fan in [from, to] {
                if wall[fan as usize].is_none() {
                    wall[fan as usize] = Some(self.vertices.len() as u32);
                    let point = self.points[fan as usize];
                    let sides = [SheetSide::Above, SheetSide::Below];
                    let corners = sides.map(|side| ThickVertex { point, side, wall: true, fan });
                    self.vertices.extend(corners);
                }
            }
            let corners = [from, to].map(|&fan| wall[fan as usize]);
            if let [Some(a), Some(b)] = corners {
                self.triangles.extend([[b, a, a + 1], [b, a + 1, b + 1]]);
            }
        }
    }

    /// Whether it has a thickness, and so shows each of its faces to one side only.
    #[must_use]
    pub fn is_thick(&self) -> bool {
        self.thickness > 0.0
    }

    /// Where its vertices are, from the places of its points \[m\]. `half`: half the thickness
    /// there \[m\], by the number of a point.
    #[must_use]
    pub fn placed(&self, places: &[Vec3], half: impl Fn(u32) -> f64) -> PlacedSheet {
        let at = |fan: u32| places[self.points[fan as usize] as usize];
        let mut normals = vec![Vec3::zeros(); self.points.len()];
        let areas: Vec<Vec3> = self
            .middle
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(at);
                (b - a).cross(&(c - a))
            })
            .collect();
        for (corners, area) in self.middle.iter().zip(&areas) {
            corners.iter().for_each(|&fan| normals[fan as usize] += area);
        }
        let unit = |normal: &Vec3| normal.try_normalize(1e-300).unwrap_or_else(Vec3::z);
        let normals: Vec<Vec3> = normals.iter().map(unit).collect();
        let mut walls = vec![Vec3::zeros(); self.points.len()];
        for &([from, to], triangle) in &self.rims {
            let outward = (at(to) - at(from)).cross(&unit(&areas[triangle as usize]));
            walls[from as usize] += outward;
            walls[to as usize] += outward;
        }
        let vertex = |of: &ThickVertex| {
            let (normal, sign) = (normals[of.fan as usize], of.side.sign());
            let place = at(of.fan) + normal * (sign * half(of.point));
            if of.wall {
                return (place, walls[of.fan as usize].try_normalize(1e-300).unwrap_or(normal));
            }
            (place, if of.side == SheetSide::Below { -normal } else { normal })
        };
        let (places, normals) = self.vertices.iter().map(vertex).unzip();
        PlacedSheet { places, normals }
    }

    /// Where its vertices are at its own thickness.
    #[must_use]
    pub fn at(&self, places: &[Vec3]) -> PlacedSheet {
        self.placed(places, |_| 0.5 * self.thickness)
    }
}

/// A corner of a triangle, which is also the edge from it to the next.
type Corner = (u32, usize);

/// For each edge of each triangle the one edge that runs against it. Where more than two triangles
/// meet, or two of them turn differently, they are no neighbours.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<Corner>; 3]> {
    let mut edges: Vec<([u32; 2], bool, Corner)> = Vec::with_capacity(3 * triangles.len());
    for (t, corners) in (0u32..).zip(triangles) {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], a < b, (t, k)));
        }
    }
    edges.sort_unstable();
    let mut all = vec![[None; 3]; triangles.len()];
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, false, one), (_, true, other)] = same {
            all[one.0 as usize][one.1] = Some(other);
            all[other.0 as usize][other.1] = Some(one);
        }
    }
    all
}

/// Corners that meet at a point across edges are one fan. A point at which parts of a surface only
/// touch has several. Hands back the triangles by fans, and the point of each fan.
fn fans(triangles: &[[u32; 3]], neighbours: &[[Option<Corner>; 3]]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut heads: Vec<usize> = (0..3 * triangles.len()).collect();
    let find = |heads: &mut Vec<usize>, mut of: usize| {
        while heads[of] != of {
            heads[of] = heads[heads[of]];
            of = heads[of];
        }
        of
    };
    let name = |t: u32, k: usize| 3 * t as usize + k % 3;
    for (t, own) in (0u32..).zip(neighbours) {
        for (k, other) in own.iter().enumerate() {
            let Some((s, m)) = *other else { continue };
            // An edge begins where the one against it ends.
            for (a, b) in [(name(t, k), name(s, m + 1)), (name(t, k + 1), name(s, m))] {
                let (a, b) = (find(&mut heads, a), find(&mut heads, b));
                heads[a.max(b)] = a.min(b);
            }
        }
    }
    let corner = |of: usize| triangles[of / 3][of % 3];
    let mut firsts: Vec<(u32, usize)> =
        (0..heads.len()).filter(|&of| heads[of] == of).map(|of| (corner(of), of)).collect();
    firsts.sort_unstable();
    let mut number = vec![0; heads.len()];
    for (fan, &(_, of)) in (0u32..).zip(&firsts) {
        number[of] = fan;
    }
    let fan = |heads: &mut Vec<usize>, of: usize| number[find(heads, of)];
    let all = (0..triangles.len()).map(|t| [0, 1, 2].map(|k| fan(&mut heads, 3 * t + k)));
    (all.collect(), firsts.iter().map(|&(point, _)| point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::waving;
    use std::collections::BTreeMap;

    /// How often each edge is there, in its direction. Vertices that lie together are one.
    fn edges(sheet: &ThickSheet) -> BTreeMap<[(u32, SheetSide); 2], usize> {
        let name = |v: u32| {
            let of = &sheet.vertices[v as usize];
            (of.fan, of.side)
        };
        let mut count = BTreeMap::new();
        for &[a, b, c] in &sheet.triangles {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                *count.entry([name(p), name(q)]).or_insert(0) += 1;
            }
        }
        count
    }

    fn is_closed(sheet: &ThickSheet) -> bool {
        let edges = edges(sheet);
        edges.iter().all(|(&[p, q], &count)| count == 1 && edges.get(&[q, p]) == Some(&1))
    }

    /// Volume inside \[m³\].
    fn volume(sheet: &ThickSheet, placed: &PlacedSheet) -> f64 {
        let part = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| placed.places[v as usize]);
            a.dot(&b.cross(&c)) / 6.0
        };
        sheet.triangles.iter().map(part).sum()
    }

    #[test]
    fn a_sheet_whole_or_torn_is_closed_by_its_walls() {
        for torn in [false, true] {
            let surface = waving::surface(torn);
            let sheet = ThickSheet::of(&surface);
            assert!(is_closed(&sheet), "torn: {torn}");
            let rest = |&[x, y]: &[f32; 2]| Vec3::new(f64::from(x), f64::from(y), 0.0);
            let places: Vec<Vec3> = surface.reference.iter().map(rest).collect();
            let placed = sheet.at(&places);
            let due = waving::SIDE * waving::SIDE * f64::from(surface.thickness);
            let found = volume(&sheet, &placed);
            assert!((found - due).abs() < 1e-6 * due, "{found} m³ instead of {due}");
            for (normal, of) in placed.normals.iter().zip(&sheet.vertices) {
                let up = if of.wall { 0.0 } else { of.side.sign() };
                assert!((normal.z - up).abs() < 1e-12 && (normal.norm() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn parts_that_only_touch_at_a_point_stay_apart() {
        // Two triangles that share a corner; three on one edge; two that turn differently.
        let touching = vec![[0, 1, 2], [2, 3, 4]];
        let fins = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        let turned = vec![[0, 1, 2], [0, 1, 3]];
        for (triangles, fans) in [(touching, 6), (fins, 9), (turned, 6)] {
            let sheet = ThickSheet::new(&triangles, 1e-3);
            assert!(is_closed(&sheet), "{triangles:?}");
            assert_eq!(sheet.points.len(), fans, "{triangles:?}");
        }
    }

    #[test]
    fn a_surface_that_is_closed_by_itself_stays_as_it_is() {
        let block = crate::synthetic::block(Vec3::new(1.0, 2.0, 3.0), 0.0).mesh;
        let sheet = ThickSheet::new(&block.triangles, 0.0);
        assert_eq!((&sheet.triangles, sheet.vertices.len()), (&block.triangles, 8));
        assert_eq!(sheet.at(&block.vertices).places, block.vertices);
    }
}
