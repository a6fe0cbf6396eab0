//! Supports and planes of symmetry: what some nodes may not do.

use crate::mpm::grid::{BackgroundGrid, Nodes};
use crate::mpm::stencil::{packed, vector};
use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_specimen::{GridFrame, Hold, SpecimenProblem, SymmetryPlane, within};

/// Distance of a plane of symmetry from the next nodes that counts as none, in spacings.
const ON_NODES: f64 = 1e-6;

/// The nodes of a support.
#[derive(Clone, Debug, Default)]
pub(super) struct SupportNodes {
    /// Each once, with its velocity at 1 of the course in the specimen's frame \[m/s\].
    pub(super) nodes: Vec<(u32, Vec3)>,
}

/// A plane of symmetry: nodes on it, and pairs to both sides of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Mirror {
    axis: usize,
    on: Vec<u32>,
    pairs: Vec<(u32, u32)>,
}

impl SupportNodes {
    /// Holds the nodes from `first` on that were made of held ones.
    pub(super) fn follow(&mut self, nodes: &Nodes, first: u32) {
        for n in first..nodes.len() as u32 {
            let origin = nodes.origin[n as usize];
            if let Ok(at) = self.nodes.binary_search_by_key(&origin, |held| held.0) {
                self.nodes.push((n, self.nodes[at].1));
            }
        }
    }
}

/// The nodes that each support holds. Nodes outside the box around the specimen count by the
/// nearest point of that.
pub(super) fn held(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    grid: &BackgroundGrid,
) -> Vec<SupportNodes> {
    let (low, high) = specimen.body.mesh.bounds().unwrap_or_default();
    let slack = 1e-6 * specimen.settings.spacing;
    let places: Vec<Vec3> = (0..grid.nodes.len()).map(|n| frame.back(&grid.place(n))).collect();
    let nodes = |hold: &Hold| {
        let inside = |x: &Vec3| within(&hold.part, &x.sup(&low).inf(&high), slack);
        let all = (0_u32..).zip(&places).filter(|(_, x)| inside(x));
        all.map(|(n, x)| (n, hold.velocity + hold.gradient * (x - hold.centre))).collect()
    };
    specimen.holds.iter().map(|hold| SupportNodes { nodes: nodes(hold) }).collect()
}

/// The velocity that each held node shall have along the axes that it is held along, in the
/// specimen's frame \[m/s\]: the sum over its supports by the factor of each, where it has not let
/// go. `wanted` goes by node; others stay.
pub(super) fn add_up(
    held: &[SupportNodes],
    holds: &[Hold],
    factors: &[Option<f64>],
    wanted: &mut [Vec3],
) {
    let rows = held.iter().zip(holds).zip(factors);
    let active = rows.filter_map(|((held, hold), factor)| Some((held, hold, (*factor)?)));
    for (node, _) in active.clone().flat_map(|(held, _, _)| &held.nodes) {
        wanted[*node as usize] = Vec3::zeros();
    }
    for (held, hold, factor) in active {
        for (node, velocity) in &held.nodes {
            for axis in (0..3).filter(|&a| hold.axes[a]) {
                wanted[*node as usize][axis] += factor * velocity[axis];
            }
        }
    }
}

/// Pairs the nodes about each plane of symmetry.
pub(super) fn mirrors(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    grid: &BackgroundGrid,
) -> Result<Vec<Mirror>, Refusal> {
    if !specimen.symmetries.is_empty() && !frame.is_straight() {
        let (what, value) = ("the specimen's turn beside a plane of symmetry [rad]", 1.0);
        let value = specimen.body.turn.angle().max(value * f64::MIN_POSITIVE);
        return Err(Refusal::OutOfRange { what, value, low: 0.0, high: 0.0 });
    }
    specimen.symmetries.iter().map(|&plane| mirror(specimen, grid, plane)).collect()
}

fn mirror(
    specimen: &SpecimenProblem,
    grid: &BackgroundGrid,
    plane: SymmetryPlane,
) -> Result<Mirror, Refusal> {
    let axis = usize::from(plane.axis.min(2));
    let place = (plane.at + specimen.body.shift[axis]) / specimen.settings.spacing;
    let plane = place.round();
    let off = (place - plane).abs();
    if off > ON_NODES {
        let what = "distance of a plane of symmetry from the grid's nodes, in spacings,";
        return Err(Refusal::OutOfRange { what, value: off, low: 0.0, high: ON_NODES });
    }
    let plane = plane as i32;
    let keys = grid.nodes.place.iter().copied().zip(grid.nodes.body.iter().copied());
    let mut order: Vec<(([i32; 3], u8), u32)> = keys.zip(0_u32..).collect();
    order.sort_unstable();
    let at_place = |key: ([i32; 3], u8)| {
        let first = order.partition_point(|row| row.0 < key);
        order[first..].iter().take_while(move |row| row.0 == key).map(|row| row.1)
    };
    let mut mirror = Mirror { axis, ..Mirror::default() };
    for &((place, body), node) in &order {
        if place[axis] == plane {
            mirror.on.push(node);
        } else if place[axis] < plane {
            let mut opposite = place;
            opposite[axis] = 2 * plane - place[axis];
            // Sides of a crack are paired one by one only where both places have one node.
            let (own, across) = ((place, body), (opposite, body));
            if (at_place(own).count(), at_place(across).count()) == (1, 1) {
                mirror.pairs.extend(at_place(across).map(|other| (node, other)));
            }
        }
    }
    Ok(mirror)
}

impl Mirror {
    /// Takes in the nodes from `first` on, and pairs no more those that they were made of.
    pub(super) fn follow(&mut self, nodes: &Nodes, first: u32) {
        for n in first..nodes.len() as u32 {
            let origin = nodes.origin[n as usize];
            if self.on.contains(&origin) {
                self.on.push(n);
            }
            self.pairs.retain(|pair| pair.0 != origin && pair.1 != origin);
        }
    }

    /// Makes the velocities of the step that was just taken symmetric, and the places with them.
    pub(super) fn apply(&self, grid: &mut BackgroundGrid, step: f64) {
        let axis = self.axis;
        for &n in &self.on {
            let mut v = vector(grid.nodes.velocity[n as usize]);
            v[axis] = 0.0;
            set(grid, n, &v, step);
        }
        for &(a, b) in &self.pairs {
            let (first, second) = (grid.nodes.mass[a as usize], grid.nodes.mass[b as usize]);
            let (mut v, w) =
                (vector(grid.nodes.velocity[a as usize]), vector(grid.nodes.velocity[b as usize]));
            v[axis] = -v[axis];
            let mut both = (v * first + w * second) / (first + second);
            set(grid, b, &both, step);
            both[axis] = -both[axis];
            set(grid, a, &both, step);
        }
    }
}

/// Gives a node another velocity at the end of the step that was just taken.
pub(super) fn set(grid: &mut BackgroundGrid, node: u32, velocity: &Vec3, step: f64) {
    let n = node as usize;
    let change = packed(*velocity) - grid.nodes.velocity[n];
    grid.nodes.velocity[n] += change;
    grid.nodes.displacement[n] += change * wide::f64x4::splat(step);
}
