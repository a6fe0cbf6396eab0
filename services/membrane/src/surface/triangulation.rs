//! The triangles between the points of a sheet and its outline.

use cullet_continuum::bytes::held;
use cullet_model::Refusal;
use cullet_model::membrane::SheetPlace;
use spade::handles::FixedVertexHandle;
use spade::{
    ConstrainedDelaunayTriangulation, MAX_ALLOWED_VALUE, Point2, Triangulation, mitigate_underflow,
};
use std::collections::BTreeMap;

/// Side of the largest triangle that is drawn, over the spacing \[1\]. Where points are farther
/// apart there is no sheet between them.
const LONGEST_SIDE: f64 = 2.6;

/// Most vertices on one side of an outline: far above what sheets have, and memory holds them.
const MOST_STEPS: u32 = 1_000_000;

/// A side this much longer than a whole number of spacings is as long as that \[1\].
const ROUNDING: f64 = 1e-9;

/// Nothing.
pub(super) const NONE: u32 = u32::MAX;

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// A Delaunay triangulation of the points of a sheet and of vertices on its outline, which are
/// about the spacing apart. Each vertex on the outline moves with the point next to it.
/// Worked out once for a body.
#[derive(Clone, Debug)]
pub struct SheetTriangulation {
    /// Of the points, then of the vertices on the outline \[m\].
    pub(super) places: Vec<SheetPlace>,
    /// The point that each vertex moves with.
    pub(super) owners: Vec<u32>,
    /// Corners, counter-clockwise.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Edges of each triangle: number k is between its corners k and k + 1.
    pub(super) sides: Vec<[u32; 3]>,
    /// Ends, the smaller number first.
    pub(super) edges: Vec<[u32; 2]>,
    /// The pair of points whose bond holds each edge together; [`NONE`] where both ends move with
    /// the same point.
    pub(super) pair_of_edge: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl SheetTriangulation {
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let corners = held(&self.triangles) + held(&self.sides);
        let pairs = held(&self.edges) + held(&self.pair_of_edge) + held(&self.pairs);
        held(&self.places) + held(&self.owners) + corners + pairs
    }

    /// Triangulates points at rest \[m\] inside an outline, a polygon that does not touch itself.
    /// Triangles outside it, and those with a side above 2.6 times the spacing \[m\], are left
    /// out. A point outside the outline, or at the place of another, gets no triangles.
    ///
    /// # Errors
    /// An outline of fewer than three corners or that meets itself, a place that is not finite,
    /// or a spacing that is not positive.
    pub fn new(
        points: &[SheetPlace],
        outline: &[SheetPlace],
        spacing: f64,
    ) -> Result<Self, Refusal> {
        if !(spacing > 0.0 && spacing.is_finite()) {
            let high = f64::MAX;
            let low = f64::MIN_POSITIVE;
            return Err(Refusal::OutOfRange { what: "spacing", value: spacing, low, high });
        }
        let mut planar = PlanarVertices::default();
        for (i, &place) in points.iter().enumerate() {
            planar.insert(i as u32, place)?;
        }
        let mut places = points.to_vec();
        let mut ring = Vec::new();
        for place in rim(outline, spacing)? {
            let (handle, new) = planar.insert(places.len() as u32, place)?;
            if new {
                places.push(place);
            }
            if ring.last() != Some(&handle) {
                ring.push(handle);
            }
        }
        planar.enclose(&ring)?;
        let mut triangles = planar.inner_triangles();
        let side = |a: u32, b: u32| distance2(places[a as usize], places[b as usize]);
        let limit = LONGEST_SIDE * LONGEST_SIDE * spacing * spacing;
        triangles
            .retain(|&[a, b, c]| [side(a, b), side(b, c), side(c, a)].iter().all(|&s| s <= limit));
        let owners = choose_owners(&places, points.len(), &triangles);
        triangles.retain(|corners| corners.iter().all(|&v| owners[v as usize] != NONE));
        Ok(Self::connect(places, owners, triangles, points.len()))
    }

    /// Pairs of points i < j whose bonds hold the surface together, by rising numbers. They are
    /// neighbours, less than two spacings apart where points are even. A pair that never had a
    /// bond is as good as broken: a notch lies between them.
    #[must_use]
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Triangles between points whose pairs all hold, by `alive` for each of
    /// [`SheetTriangulation::pairs`]; those at the outline and along cracks are left out.
    pub(crate) fn whole(&self, alive: &[bool]) -> Vec<[u32; 3]> {
        let holds = |&e: &u32| match self.pair_of_edge[e as usize] {
            NONE => true,
            pair => alive[pair as usize],
        };
        let is_point = |&v: &u32| self.owners[v as usize] == v;
        let whole = |(corners, sides): &(&[u32; 3], &[u32; 3])| {
            corners.iter().all(is_point) && sides.iter().all(holds)
        };
        self.triangles.iter().zip(&self.sides).filter(whole).map(|(corners, _)| *corners).collect()
    }

    /// Numbers edges and pairs, and drops the vertices of the outline that no triangle has.
    fn connect(
        mut places: Vec<SheetPlace>,
        mut owners: Vec<u32>,
        mut triangles: Vec<[u32; 3]>,
        points: usize,
    ) -> Self {
        let mut number = vec![NONE; places.len()];
        triangles.iter().flatten().for_each(|&v| number[v as usize] = 0);
        number[..points].fill(0);
        let kept: Vec<usize> = (0..places.len()).filter(|&v| number[v] == 0).collect();
        kept.iter().enumerate().for_each(|(new, &old)| number[old] = new as u32);
        places = kept.iter().map(|&v| places[v]).collect();
        owners = kept.iter().map(|&v| owners[v]).collect();
        for corners in &mut triangles {
            *corners = corners.map(|v| number[v as usize]);
        }
        let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
        let ends = |&[a, b, c]: &[u32; 3]| [sorted(a, b), sorted(b, c), sorted(c, a)];
        let edges = unique(triangles.iter().flat_map(ends));
        let find = |list: &[[u32; 2]], item| list.binary_search(&item).map_or(NONE, |i| i as u32);
        let sides = triangles.iter().map(|t| ends(t).map(|edge| find(&edges, edge))).collect();
        let pair = |&[a, b]: &[u32; 2]| sorted(owners[a as usize], owners[b as usize]);
        let pairs = unique(edges.iter().map(pair).filter(|[i, j]| i != j));
        let pair_of_edge = edges.iter().map(|edge| find(&pairs, pair(edge))).collect();
        Self { places, owners, triangles, sides, edges, pair_of_edge, pairs }
    }
}

fn unique(items: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
    let mut list: Vec<_> = items.collect();
    list.sort_unstable();
    list.dedup();
    list
}

pub(super) fn distance2([a, b]: SheetPlace, [c, d]: SheetPlace) -> f64 {
    (c - a) * (c - a) + (d - b) * (d - b)
}

/// The corners of an outline, and places between them about a spacing apart. They begin half a
/// step from the corners: rows of points do so too, and each place is then next to a point of its
/// own rather than between two.
fn rim(outline: &[SheetPlace], spacing: f64) -> Result<Vec<SheetPlace>, Refusal> {
    let corners = outline.len();
    if corners < 3 {
        return Err(unfit(format!("its outline has {corners} corners; at least 3 are needed")));
    }
    let mut places = Vec::new();
    for (k, &[a, b]) in outline.iter().enumerate() {
        let [c, d] = outline[(k + 1) % corners];
        let length = distance2([a, b], [c, d]).sqrt();
        let count = (length / spacing - ROUNDING).ceil();
        if count.is_nan() || count > f64::from(MOST_STEPS) {
            let most = format!("at most {MOST_STEPS} spacings are taken");
            return Err(unfit(format!("side {k} of its outline is {length:.3e} m long; {most}")));
        }
        places.push([a, b]);
        if count > 1.0 {
            let part = |step: u32| (f64::from(step) + 0.5) / count;
            places.extend((0..count as u32).map(part).map(|t| [a + (c - a) * t, b + (d - b) * t]));
        }
    }
    Ok(places)
}

fn unfit(lack: String) -> Refusal {
    Refusal::Unfit { solver: "membrane", lack }
}

/// The library's triangulation, and which vertex of ours each of its own is.
#[derive(Default)]
struct PlanarVertices {
    cdt: Cdt,
    numbers: Vec<u32>,
}

impl PlanarVertices {
    /// Whether the vertex is new, beside its handle: there may be one at that place.
    fn insert(
        &mut self,
        number: u32,
        place: SheetPlace,
    ) -> Result<(FixedVertexHandle, bool), Refusal> {
        let at = mitigate_underflow(Point2::new(place[0], place[1]));
        let handle = self.cdt.insert(at);
        let [x, y] = place;
        let handle = handle.map_err(|_| {
            let most = format!("coordinates must be finite and below {MAX_ALLOWED_VALUE:.0e} m");
            unfit(format!("a place is ({x:e}, {y:e}) m; {most}"))
        })?;
        let new = self.cdt.num_vertices() > self.numbers.len();
        if new {
            self.numbers.push(number);
        }
        Ok((handle, new))
    }

    /// Makes the ring a border that no triangle crosses.
    fn enclose(&mut self, ring: &[FixedVertexHandle]) -> Result<(), Refusal> {
        let mut met = vec![false; self.numbers.len()];
        for (k, &from) in ring.iter().enumerate() {
            let to = ring[(k + 1) % ring.len()];
            let again = std::mem::replace(&mut met[from.index()], true);
            if again || !self.cdt.can_add_constraint(from, to) {
                let [x, y]: SheetPlace = self.cdt.vertex(from).position().into();
                return Err(unfit(format!("its outline meets itself near ({x:.3e}, {y:.3e}) m")));
            }
            self.cdt.add_constraint(from, to);
        }
        Ok(())
    }

    /// Triangles inside the border: those that cannot be reached from outside without crossing it.
    /// Sorted, so that their order is one of places and numbers alone.
    fn inner_triangles(&self) -> Vec<[u32; 3]> {
        let mut outside = vec![false; self.cdt.num_all_faces()];
        let mut reached: Vec<_> = self.cdt.convex_hull().collect();
        while let Some(edge) = reached.pop() {
            if edge.is_constraint_edge() {
                continue;
            }
            let Some(face) = edge.rev().face().as_inner() else {
                continue;
            };
            if !std::mem::replace(&mut outside[face.fix().index()], true) {
                reached.extend(face.adjacent_edges());
            }
        }
        let inner = self.cdt.inner_faces().filter(|face| !outside[face.fix().index()]);
        let corners = inner.map(|face| face.vertices().map(|v| self.numbers[v.fix().index()]));
        let mut triangles: Vec<_> = corners.map(smallest_first).collect();
        triangles.sort_unstable();
        triangles
    }
}

fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    let least = a.min(b).min(c);
    if least == a {
        [a, b, c]
    } else if least == b {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The point that each vertex moves with: a point with itself, a vertex of the outline with the
/// nearest of the points that it shares an edge with. A vertex that shares one with none goes with
/// its neighbours on the outline, so that what moves with a point is joined to it.
fn choose_owners(places: &[SheetPlace], points: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut owners: Vec<u32> = (0..places.len() as u32).collect();
    owners[points..].fill(NONE);
    loop {
        let mut nearest: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
        let around = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a], [b, a], [c, b], [a, c]];
        for [from, to] in triangles.iter().flat_map(around) {
            let owner = owners[to as usize];
            if owners[from as usize] != NONE || owner == NONE {
                continue;
            }
            let found = (distance2(places[from as usize], places[owner as usize]), owner);
            let best = nearest.entry(from).or_insert(found);
            if found.0 < best.0 || (found.0 == best.0 && owner < best.1) {
                *best = found;
            }
        }
        if nearest.is_empty() {
            return owners;
        }
        nearest.iter().for_each(|(&v, &(_, owner))| owners[v as usize] = owner);
    }
}
