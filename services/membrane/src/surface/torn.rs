//! The surface of a sheet with the cracks that it has.

use super::crack::CrackNet;
use super::triangulation::{NONE, SheetTriangulation};
use cullet_geometry::Vec3;
use cullet_model::continuum::MovingSurface;
use cullet_model::membrane::SheetPlace;

/// How a vertex hangs on a point: it is at x + F·offset of that point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceTie {
    /// The point.
    pub point: u32,
    /// From the point to the vertex, at rest \[m\].
    pub offset: SheetPlace,
}

/// A surface that opens along cracks, and how its vertices follow the points of its sheet. It
/// holds until another bond breaks.
///
/// The first vertices are the points themselves, in their order; a point without triangles is
/// among them. Then come the vertices on the outline, which are the same whatever is broken, then
/// those along cracks.
#[derive(Clone, Debug, PartialEq)]
pub struct TornSurface {
    /// Its triangles, and its vertices at rest. Both lips of a crack have the same places there.
    pub surface: MovingSurface,
    /// Number of the first tie of each vertex, and the number of ties at the end.
    first: Vec<u32>,
    ties: Vec<SurfaceTie>,
}

impl TornSurface {
    /// The surface of a sheet. `alive` says for each of [`SheetTriangulation::pairs`] whether
    /// a bond still holds the two points together; `thickness` \[m\] is drawn.
    ///
    /// # Panics
    /// If `alive` has another length than the pairs.
    #[must_use]
    pub fn new(sheet: &SheetTriangulation, alive: &[bool], thickness: f32) -> Self {
        assert_eq!(alive.len(), sheet.pairs().len(), "one flag for each pair");
        let is_dead = |&pair: &u32| pair != NONE && !alive[pair as usize];
        let dead: Vec<bool> = sheet.pair_of_edge.iter().map(is_dead).collect();
        let net = CrackNet::new(sheet, &dead);
        let mut torn = Self::of_vertices(sheet, thickness);
        // Where an edge is broken each of its ends has a middle of its own.
        let mut middles = vec![[NONE; 2]; sheet.edges.len()];
        for (e, ends) in sheet.edges.iter().enumerate().filter(|&(e, _)| dead[e]) {
            let place = net.places[net.of_edge[e] as usize];
            middles[e] = ends.map(|end| torn.add(sheet, place, &[end]));
        }
        for (t, &corners) in sheet.triangles.iter().enumerate() {
            if net.of_triangle[t] == NONE {
                torn.surface.triangles.push(corners);
                continue;
            }
            let sides = sheet.sides[t].map(|e| e as usize);
            let place = net.places[net.of_triangle[t] as usize];
            let centres = torn.add_centres(sheet, place, corners, sides.map(|e| dead[e]));
            for (k, e) in sides.into_iter().enumerate() {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let (of_a, of_b) = (centres[k], centres[(k + 1) % 3]);
                if dead[e] {
                    let [low, high] = middles[e];
                    let (at_a, at_b) = if a < b { (low, high) } else { (high, low) };
                    torn.surface.triangles.extend([[a, at_a, of_a], [at_b, b, of_b]]);
                } else {
                    torn.surface.triangles.push([a, b, of_a]);
                }
            }
        }
        torn
    }

    /// Where its vertices are \[m\], with the points at `x` \[m\] and their deformation gradients:
    /// how x changes along the two coordinates of the sheet at rest \[1\]. A point's vertex is at
    /// its x to the last bit; one that hangs on several points is in the middle of where each has
    /// it.
    ///
    /// # Panics
    /// If there are fewer places or gradients than points.
    #[must_use]
    pub fn places(&self, x: &[Vec3], gradient: &[[Vec3; 2]]) -> Vec<Vec3> {
        let place = |tie: &SurfaceTie| {
            let (i, [u, v]) = (tie.point as usize, tie.offset);
            if [u, v] == [0.0; 2] { x[i] } else { x[i] + gradient[i][0] * u + gradient[i][1] * v }
        };
        let middle = |ties: &[SurfaceTie]| match ties {
            [tie] => place(tie),
            ties => ties.iter().map(place).sum::<Vec3>() / ties.len() as f64,
        };
        self.each_vertex().map(middle).collect()
    }

    /// A quantity at its vertices, from its values at the points.
    ///
    /// # Panics
    /// If there are fewer values than points.
    #[must_use]
    pub fn quantities(&self, values: &[f64]) -> Vec<f32> {
        let sum = |ties: &[SurfaceTie]| ties.iter().map(|t| values[t.point as usize]).sum::<f64>();
        self.each_vertex().map(|ties| (sum(ties) / ties.len() as f64) as f32).collect()
    }

    /// The same without what hangs on some points. Those that are left lose their numbers.
    ///
    /// # Panics
    /// If there are fewer flags than points.
    #[must_use]
    pub fn without(&self, gone: &[bool]) -> Self {
        let kept = |ties: &[SurfaceTie]| !gone[ties[0].point as usize];
        let thickness = self.surface.thickness;
        let surface = MovingSurface { thickness, ..MovingSurface::default() };
        let mut rest = Self { surface, first: vec![0], ties: Vec::new() };
        let mut number = Vec::new();
        for (v, ties) in self.each_vertex().enumerate() {
            number.push(rest.surface.reference.len() as u32);
            if kept(ties) {
                rest.ties.extend(ties);
                rest.first.push(rest.ties.len() as u32);
                rest.surface.reference.push(self.surface.reference[v]);
            }
        }
        let left = self.surface.triangles.iter().filter(|corners| kept(self.ties(corners[0])));
        let renumbered = left.map(|corners| corners.map(|v| number[v as usize]));
        rest.surface.triangles = renumbered.collect();
        rest
    }

    /// What a vertex hangs on: one point, or two or three where a crack ends or passes by.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn ties(&self, vertex: u32) -> &[SurfaceTie] {
        let [from, to] = [0, 1].map(|next| self.first[vertex as usize + next] as usize);
        &self.ties[from..to]
    }

    fn each_vertex(&self) -> impl Iterator<Item = &[SurfaceTie]> {
        self.first.windows(2).map(|ends| &self.ties[ends[0] as usize..ends[1] as usize])
    }

    /// The vertices of the triangulation, without triangles.
    fn of_vertices(sheet: &SheetTriangulation, thickness: f32) -> Self {
        let surface = MovingSurface { thickness, ..MovingSurface::default() };
        let mut torn = Self { surface, first: vec![0], ties: Vec::new() };
        for (v, &place) in sheet.places.iter().enumerate() {
            torn.add(sheet, place, &[v as u32]);
        }
        torn
    }

    /// The middles of a torn triangle, as each of its corners has them: corners that are still
    /// joined have one together.
    fn add_centres(
        &mut self,
        sheet: &SheetTriangulation,
        place: SheetPlace,
        corners: [u32; 3],
        dead: [bool; 3],
    ) -> [u32; 3] {
        let mut joined = (0..3).filter(|&k| !dead[k]);
        match (joined.next(), joined.next()) {
            (Some(k), None) => {
                let (a, b, lone) = (k, (k + 1) % 3, (k + 2) % 3);
                let mut centres = [self.add(sheet, place, &[corners[a], corners[b]]); 3];
                centres[lone] = self.add(sheet, place, &[corners[lone]]);
                centres
            }
            (None, _) => corners.map(|corner| self.add(sheet, place, &[corner])),
            _ => [self.add(sheet, place, &corners); 3],
        }
    }

    /// A vertex at a place at rest that hangs on the points of some vertices.
    fn add(&mut self, sheet: &SheetTriangulation, place: SheetPlace, with: &[u32]) -> u32 {
        for &vertex in with {
            let point = sheet.owners[vertex as usize];
            let [x, y] = sheet.places[point as usize];
            let offset = [place[0] - x, place[1] - y];
            self.ties.push(SurfaceTie { point, offset });
        }
        self.first.push(self.ties.len() as u32);
        self.surface.reference.push(place.map(|coordinate| coordinate as f32));
        self.surface.reference.len() as u32 - 1
    }
}
