//! Where the cells of a piece are to be: at guide points first, then dense near the hits.

use super::guarded::{HeldRegions, LabelledSites};
use super::piece::DirectedPiece;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::math::unit;
use cullet_geometry::{TriMesh, Vec3};
use cullet_model::{BodyRegion, Impact};

/// Cells grow from a hit with a length of this share of the body's size, or twice the contact
/// radius where that is more: as the geometric family's do.
const CORE: f64 = 0.1;
/// Points that weigh a piece, about.
const WEIGHED: f64 = 200.0;
/// Points for each cell to choose from, about.
const CHOICE: f64 = 40.0;
/// Most points of the lattice, those outside the piece included.
const MAX_LATTICE: f64 = 1e6;

/// How densely cells lie: 1/(1 + r/r₀)² at the distance r to the nearest hit.
#[derive(Clone, Debug)]
pub(super) struct HitDensity {
    /// Where, and r₀ \[m\].
    hits: Vec<(Vec3, f64)>,
}

impl HitDensity {
    /// `size`: of the body \[m\].
    pub(super) fn new(impacts: &[Impact], size: f64) -> Self {
        let hit = |impact: &Impact| (impact.point, (2.0 * impact.radius).max(CORE * size));
        Self { hits: impacts.iter().map(hit).collect() }
    }

    fn at(&self, place: &Vec3) -> f64 {
        let from = |(point, core): &(Vec3, f64)| 1.0 + (place - point).norm() / core;
        let nearest = self.hits.iter().map(from).fold(f64::INFINITY, f64::min);
        if nearest.is_finite() { 1.0 / (nearest * nearest) } else { 1.0 }
    }

    /// The density over a piece, summed up \[m³\].
    pub(super) fn weight(&self, piece: &DirectedPiece, seed: u64) -> f64 {
        let volume = piece.properties.volume;
        let points = inner_points(&piece.fragment.solid.mesh, volume, WEIGHED, seed);
        let mean = match points.len() {
            0 => self.at(&piece.properties.centroid),
            count => points.iter().map(|p| self.at(p)).sum::<f64>() / count as f64,
        };
        volume * mean
    }
}

/// How many cells each piece is to have so that there are `wanted` in all: one, and the others by
/// weight, one at a time to where cells are the largest (D'Hondt's rule).
pub(super) fn allotted(weights: &[f64], wanted: usize) -> Vec<usize> {
    let mut cells = vec![1; weights.len()];
    for _ in weights.len()..wanted {
        let size = |k: &usize| weights[*k] / cells[*k] as f64;
        let largest = (0..weights.len()).max_by(|a, b| size(a).total_cmp(&size(b)).then(b.cmp(a)));
        match largest.filter(|k| weights[*k] > 0.0) {
            Some(k) => cells[k] += 1,
            None => break,
        }
    }
    cells
}

/// Sites of so many cells in a piece: at its guide points, of what stays whole in it, and others
/// sampled by density without replacement, none within what stays whole.
pub(super) fn with_guides(
    piece: &DirectedPiece,
    (guides, whole): (&[Vec3], &[BodyRegion]),
    count: usize,
    density: &HitDensity,
    seed: u64,
) -> LabelledSites {
    let mesh = &piece.fragment.solid.mesh;
    let held = HeldRegions::new(mesh, whole);
    let mut sites: Vec<Vec3> = guides.iter().filter(|guide| !held.has(guide)).copied().collect();
    let more = count.saturating_sub(sites.len() + held.count());
    // A region that is nearly all of a piece still leaves one cell beside it.
    let more = if sites.is_empty() { more.max(1) } else { more };
    let wanted = CHOICE * count as f64;
    let points = inner_points(mesh, piece.properties.volume, wanted, seed);
    // Weighted draw without replacement: order by u^(1/w), u uniform in (0, 1).
    let lot = |(i, p): (usize, Vec3)| {
        let u = unit(seed, 3, i as u64).max(f64::MIN_POSITIVE);
        (-libm::log(u) / density.at(&p), i, p)
    };
    let mut drawn: Vec<(f64, usize, Vec3)> =
        points.into_iter().filter(|p| held.is_clear(p)).enumerate().map(lot).collect();
    drawn.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    sites.extend(drawn.into_iter().take(more).map(|(.., site)| site));
    held.around(&sites, seed)
}

/// About so many points inside a mesh, one at random in each cell of a lattice.
fn inner_points(mesh: &TriMesh, volume: f64, wanted: f64, seed: u64) -> Vec<Vec3> {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let extent = high - low;
    let width = libm::cbrt(volume / wanted);
    let mut counts = extent.map(|x| (x / width).max(1.0).ceil());
    let total = counts.product();
    if total > MAX_LATTICE {
        let scale = libm::cbrt(MAX_LATTICE / total);
        counts = counts.map(|n| (n * scale).max(1.0).floor());
    }
    let dims = [0, 1, 2].map(|k| counts[k] as usize);
    let step = extent.component_div(&counts);
    let inside = Inside::new(mesh);
    let place = |i: usize| {
        let row = i / dims[0];
        let node = [i % dims[0], row % dims[1], row / dims[1]];
        let at = |k: usize| node[k] as f64 + unit(seed, k as u64, i as u64);
        low + Vec3::new(at(0), at(1), at(2)).component_mul(&step)
    };
    (0..dims.iter().product()).map(place).filter(|&p| inside.contains(p)).collect()
}

/// The piece that holds each guide point, or else the nearest.
pub(super) fn holders(pieces: &[DirectedPiece], guides: &[Vec3]) -> Vec<usize> {
    if guides.is_empty() {
        return Vec::new();
    }
    let tests: Vec<(Inside, Nearest)> = pieces
        .iter()
        .map(|piece| &piece.fragment.solid.mesh)
        .map(|mesh| (Inside::new(mesh), Nearest::new(mesh)))
        .collect();
    let holder = |guide: &Vec3| {
        let held = tests.iter().position(|(inside, _)| inside.contains(*guide));
        let far = |k: &usize| tests[*k].1.distance(*guide);
        let nearest = || (0..tests.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
        held.or_else(nearest).unwrap_or_default()
    };
    guides.iter().map(holder).collect()
}
