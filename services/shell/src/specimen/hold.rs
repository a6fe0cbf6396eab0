//! Supports: what some control points may not do.

use super::build::{AlignedPlate, PlateDomain};
use cullet_geometry::Vec3;
use cullet_simd::Real;
use cullet_specimen::{Hold, SpecimenProblem, StepTally};
use std::collections::BTreeMap;

/// Heights of a support that are looked at \[t\]: both faces and the middle.
const HEIGHTS: [f64; 3] = [-0.5, 0.0, 0.5];

/// A control point that a support holds.
#[derive(Clone, Copy, Debug)]
struct HeldNode {
    node: u32,
    /// Along which axes of the plate.
    axes: [bool; 3],
    /// Its velocity at 1 of the course, in the plate's frame \[m/s\].
    velocity: Vec3,
}

/// Control points at edges whose slope is held where the deflection is not: their deflections
/// differ by what the slope makes of their distances.
#[derive(Clone, Debug, Default)]
struct SlopeGroup {
    /// Each with its velocity over that of the first at 1 of the course \[m/s\].
    nodes: Vec<(u32, f64)>,
}

/// What a support holds.
#[derive(Clone, Debug, Default)]
pub(super) struct HeldNodes {
    held: Vec<HeldNode>,
    groups: Vec<SlopeGroup>,
}

/// Control points of the sheet by column and row.
#[derive(Clone, Copy, Debug)]
struct SheetGrid {
    count: [usize; 2],
}

impl SheetGrid {
    /// Of the control points of a sheet, row by row.
    fn new(nodes: &[Vec3]) -> Self {
        let first = nodes[0].y;
        let columns = nodes.iter().take_while(|x| x.y == first).count();
        Self { count: [columns, nodes.len() / columns] }
    }

    /// The control point beside one at an edge, inward along an axis; none elsewhere.
    fn inward(&self, node: usize, axis: usize) -> Option<usize> {
        let [columns, _] = self.count;
        let place = [node % columns, node / columns][axis];
        let stride = [1, columns][axis];
        match place {
            0 => Some(node + stride),
            k if k + 1 == self.count[axis] => Some(node - stride),
            _ => None,
        }
    }
}

impl HeldNodes {
    /// Whether it holds nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.held.is_empty() && self.groups.is_empty()
    }

    /// Ties a control point to another: v₁ = v₀ + apart. What is tied already goes along.
    fn tie(&mut self, [first, second]: [u32; 2], apart: f64) {
        let mut take = |node: u32| {
            let own = |group: &SlopeGroup| group.nodes.iter().any(|row| row.0 == node);
            let group = self.groups.iter().position(own).map(|k| self.groups.swap_remove(k));
            group.unwrap_or(SlopeGroup { nodes: vec![(node, 0.0)] })
        };
        let mut group = take(first);
        let off = |group: &SlopeGroup, node: u32| {
            group.nodes.iter().find(|row| row.0 == node).map(|row| row.1)
        };
        if off(&group, second).is_none() {
            let other = take(second);
            let shift =
                off(&group, first).unwrap_or(0.0) + apart - off(&other, second).unwrap_or(0.0);
            group.nodes.extend(other.nodes.into_iter().map(|(node, own)| (node, own + shift)));
        }
        self.groups.push(group);
    }

    /// Holds copies of held control points from `first` on.
    pub(super) fn follow(&mut self, origin: &[u32], first: usize) {
        let own = self.held.clone();
        for (n, from) in origin.iter().enumerate().skip(first) {
            let copies = own.iter().filter(|held| held.node == *from);
            self.held.extend(copies.map(|held| HeldNode { node: n as u32, ..*held }));
        }
    }
}

/// Finds what a support holds.
struct HoldSearch<'a> {
    hold: &'a Hold,
    shape: &'a AlignedPlate,
    nodes: &'a [Vec3],
    grid: SheetGrid,
    slack: f64,
}

/// What each support holds. Control points outside the box around the specimen count by the nearest
/// point of that.
pub(super) fn held<R: Real>(
    specimen: &SpecimenProblem,
    shape: &AlignedPlate,
    domain: &PlateDomain<R>,
) -> Vec<HeldNodes> {
    let nodes = &domain.surface.nodes;
    let (grid, slack) = (SheetGrid::new(nodes), 1e-6 * specimen.settings.spacing);
    let search = |hold| HoldSearch { hold, shape, nodes, grid, slack }.found();
    specimen.holds.iter().map(search).collect()
}

impl HoldSearch<'_> {
    fn found(&self) -> HeldNodes {
        let [a, b] = self.shape.plate.size;
        let half = Vec3::new(0.5 * a, 0.5 * b, 0.0);
        let axes = self.shape.axes.map(|axis| self.hold.axes[axis]);
        let mut all = HeldNodes::default();
        let mut edges = Vec::new();
        for (n, x) in self.nodes.iter().enumerate() {
            let inner = x.sup(&-half).inf(&half);
            let [low, middle, high] = HEIGHTS
                .map(|height| self.shape.within(&self.hold.part, &inner, height, self.slack));
            if low || middle || high {
                let velocity = self.velocity(x, 0.0);
                all.held.push(HeldNode { node: n as u32, axes, velocity });
            }
            if low && high {
                edges.push(n);
            }
        }
        for n in edges {
            for axis in (0..2).filter(|&axis| axes[axis]) {
                self.hold_slope(&mut all, n, axis, axes[2]);
            }
        }
        all
    }

    /// At 1 of the course, at a height over a place of the midsurface \[t\], in the plate's frame.
    fn velocity(&self, x: &Vec3, height: f64) -> Vec3 {
        let at = x + Vec3::z() * (height * self.shape.plate.thickness);
        let from = self.shape.frame.back(&at) - self.hold.centre;
        self.shape.frame.turned(&(self.hold.velocity + self.hold.gradient * from))
    }

    /// Where both faces are held along an axis of the plane, θ = (v₊ − v₋)/t is given and with it
    /// the slope w,α = −θ_α, which at an edge the next control point inward decides.
    fn hold_slope(&self, all: &mut HeldNodes, node: usize, axis: usize, is_held_across: bool) {
        let Some(inner) = self.grid.inward(node, axis) else { return };
        let x = &self.nodes[node];
        let turn = self.velocity(x, 0.5)[axis] - self.velocity(x, -0.5)[axis];
        let slope = -turn / self.shape.plate.thickness;
        let apart = slope * (self.nodes[inner][axis] - x[axis]);
        if !is_held_across {
            all.tie([node as u32, inner as u32], apart);
            return;
        }
        let is_held = |held: &HeldNode| held.node == inner as u32 && held.axes[2];
        if !all.held.iter().any(is_held) {
            let velocity = Vec3::z() * (self.velocity(x, 0.0).z + apart);
            all.held.push(HeldNode { node: inner as u32, axes: [false, false, true], velocity });
        }
    }
}

/// What the control points did in the step that was just taken.
pub(super) struct TakenStep<'a> {
    /// Time step \[s\].
    pub(super) step: f64,
    /// Factor of each support; none where it has let go.
    pub(super) factors: &'a [Option<f64>],
    /// Velocities before it, of those that there are now \[m/s\].
    pub(super) before: &'a [Vec3],
}

/// Gives held control points their velocities; the work that this took \[J\], and the force of
/// each support in the plate's frame \[N\]. The first of several supports that hold a control point
/// along an axis has the whole force.
pub(super) fn apply<R: Real>(
    domain: &mut PlateDomain<R>,
    held: &[HeldNodes],
    taken: &TakenStep<'_>,
    tally: &mut StepTally,
) {
    let mut wanted: BTreeMap<u32, [Option<f64>; 3]> = BTreeMap::new();
    let active = || {
        let rows = held.iter().zip(taken.factors).enumerate();
        rows.filter_map(|(k, (held, factor))| Some((k, held, (*factor)?)))
    };
    for (_, held, factor) in active() {
        for one in &held.held {
            let row = wanted.entry(one.node).or_default();
            for axis in (0..3).filter(|&axis| one.axes[axis]) {
                row[axis] = Some(row[axis].unwrap_or(0.0) + factor * one.velocity[axis]);
            }
        }
    }
    let deflections: BTreeMap<u32, f64> =
        wanted.iter().filter_map(|(&n, row)| Some((n, row[2]?))).collect();
    tally.reactions = vec![Vec3::zeros(); held.len()];
    for (support, held, factor) in active() {
        for one in &held.held {
            let n = one.node as usize;
            let mut push = Vec3::zeros();
            let row = wanted.entry(one.node).or_default();
            for axis in (0..3).filter(|&axis| one.axes[axis]) {
                let Some(velocity) = row[axis].take() else { continue };
                push[axis] = (velocity - domain.velocity[n][axis]) * domain.mass[n];
            }
            give(domain, taken, n, push, tally);
            tally.reactions[support] += push / taken.step;
        }
        for group in &held.groups {
            let fixed = |&(n, off): &(u32, f64)| Some(deflections.get(&n)? - factor * off);
            let own = |&(n, off): &(u32, f64)| {
                let mass = domain.mass[n as usize];
                (mass, mass * (domain.velocity[n as usize].z - factor * off))
            };
            let sum = |a: (f64, f64), b: (f64, f64)| (a.0 + b.0, a.1 + b.1);
            let (mass, momentum) = group.nodes.iter().map(own).fold((0.0, 0.0), sum);
            let common = group.nodes.iter().find_map(fixed).unwrap_or(momentum / mass);
            for &(node, off) in &group.nodes {
                let n = node as usize;
                let change = common + factor * off - domain.velocity[n].z;
                give(domain, taken, n, Vec3::z() * (change * domain.mass[n]), tally);
            }
        }
    }
}

/// Gives a control point an impulse at the end of the step that was just taken.
fn give<R: Real>(
    domain: &mut PlateDomain<R>,
    taken: &TakenStep<'_>,
    n: usize,
    push: Vec3,
    tally: &mut StepTally,
) {
    let change = push / domain.mass[n];
    domain.velocity[n] += change;
    (0..3).for_each(|axis| domain.displacement[n][axis] += change[axis] * taken.step);
    tally.held += push.dot(&(taken.before[n] + domain.velocity[n])) / 2.0;
}
