//! A block of elements: their points, sixteen elements side by side, and the nodes they share.

use super::NodeVectors;
use super::law::{Effective, PointLaw, WATCH, flowing, idle, rests, second_piola, stiffness};
use super::spline::{basis, fall, gather, rise, scatter};
use super::tension::weakened;
use crate::mpm::elastic::{CRUSHED, LOOSE};
use crate::mpm::grid::{AROUND, GridElement, Nodes};
use crate::mpm::stencil::{Stencil, gather as gather_one};
use crate::mpm::tally::DomainTally;
use crate::particles::{Particles, ParticlesMut};
use cullet_geometry::Vec3;
use cullet_simd::{LANES, Lanes, Real, V, load, store};
use fearless_simd::{Select, Simd, SimdBase, SimdMask};
use std::cmp::Reverse;

/// A displacement \[m\] that is none: less would be subnormal in f32.
const STILL: f64 = 1e-24;

/// No point.
const NONE: u32 = u32::MAX;

/// A vector at a node; the fourth is nothing.
pub(super) type Four<R> = [R; 4];

/// One point of each of sixteen elements.
#[derive(Clone, Debug)]
struct PointLanes<R> {
    /// Place in the cell from the middle node, by axis, in cells.
    at: [Lanes<R>; 3],
    /// Minus the volume \[m³\]; none where there is no point.
    weight: Lanes<R>,
    /// Principal stress below which damage does not grow \[Pa\].
    limit: Lanes<R>,
    /// Share of a pull that damage takes \[1\]; all where the point is broken.
    taken: Lanes<R>,
    /// Whether there is any.
    damaged: bool,
    /// μ, λ/2 and μ + λ/2 \[Pa\] where not all are those of the first material.
    own: Option<Box<[Lanes<R>; 3]>>,
    /// C_p⁻¹ − I where a point has flowed \[1\].
    flowed: Option<Box<[Lanes<R>; 6]>>,
    /// The point, counted from the block's first, or [`NONE`].
    point: [u32; LANES],
}

/// Sixteen elements side by side.
#[derive(Clone, Debug)]
struct Tile<R> {
    /// The nodes of each, by place in the block's list.
    nodes: [[u16; AROUND]; LANES],
    slots: Vec<PointLanes<R>>,
}

/// Neighbouring elements, their points, and the nodes that these see.
#[derive(Clone, Debug)]
pub(super) struct Block<R> {
    /// The nodes, ascending.
    pub(super) nodes: Vec<u32>,
    tiles: Vec<Tile<R>>,
    /// The limits and the damage are not those of the points.
    pub(super) stale: bool,
}

/// What a thread needs beside a block.
pub(super) struct Scratch<R> {
    nodes: Vec<Four<R>>,
    field: Box<NodeVectors<R>>,
    forces: Box<NodeVectors<R>>,
}

impl<R: Real> Scratch<R> {
    pub(super) fn new() -> Self {
        let zero = [Lanes([R::of(0.0); LANES]); 81];
        Self { nodes: Vec::new(), field: Box::new(zero), forces: Box::new(zero) }
    }
}

impl<R: Real> Block<R> {
    /// Puts elements side by side, those with most points first, so that few lanes lie idle;
    /// `places` is zero for every node, before and after.
    pub(super) fn new(
        elements: &[GridElement],
        particles: &Particles,
        spacing: &Vec3,
        places: &mut [u16],
    ) -> Self {
        let mut nodes: Vec<u32> = Vec::new();
        for &node in elements.iter().flat_map(|e| &e.nodes) {
            if places[node as usize] == 0 {
                places[node as usize] = 1;
                nodes.push(node);
            }
        }
        nodes.sort_unstable();
        for (place, &node) in nodes.iter().enumerate() {
            places[node as usize] = place as u16;
        }
        let first = elements[0].first;
        let mut order: Vec<&GridElement> = elements.iter().collect();
        order.sort_by_key(|element| Reverse(element.count));
        let tile = |elements: &[&GridElement]| {
            let mut tile = Tile { nodes: [[0; AROUND]; LANES], slots: Vec::new() };
            for (lane, element) in elements.iter().enumerate() {
                tile.nodes[lane] = element.nodes.map(|node| places[node as usize]);
                for (slot, p) in element.points().enumerate() {
                    if slot == tile.slots.len() {
                        tile.slots.push(PointLanes::empty());
                    }
                    let x = &particles.reference[p];
                    tile.slots[slot].put(lane, x, spacing, particles.volume[p]);
                    tile.slots[slot].point[lane] = p as u32 - first;
                }
            }
            tile
        };
        let tiles = order.chunks(LANES).map(tile).collect();
        nodes.iter().for_each(|&node| places[node as usize] = 0);
        Self { nodes, tiles, stale: true }
    }

    /// Forces \[N\] of the points on the block's nodes, and what damage does to the points.
    #[inline(always)]
    pub(super) fn strain<S: Simd>(
        &mut self,
        simd: S,
        law: &PointLaw<'_>,
        nodes: &Nodes,
        view: &mut ParticlesMut<'_>,
        forces: &mut [Four<R>],
        scratch: &mut Scratch<R>,
    ) -> DomainTally {
        if self.stale {
            self.watch(law, view);
        }
        let tallies = [DomainTally::default(); LANES];
        let mut cold = Cold { law, nodes, ids: &self.nodes, view, tallies };
        take(&self.nodes, nodes, &mut scratch.nodes);
        forces.fill([R::of(0.0); 4]);
        for tile in &mut self.tiles {
            fill(&tile.nodes, &scratch.nodes, &mut scratch.field);
            let mut lane = 0;
            while lane < LANES {
                rise(simd, &mut scratch.field, lane);
                column(simd, tile, lane, &scratch.field, &mut scratch.forces, &mut cold);
                fall(simd, &mut scratch.forces, lane);
                lane += V::<S, R>::LEN;
            }
            drain(&tile.nodes, &scratch.forces, forces);
        }
        cold.tallies.into_iter().fold(DomainTally::default(), DomainTally::add)
    }

    /// Takes limits and damage from the points.
    fn watch(&mut self, law: &PointLaw<'_>, view: &ParticlesMut<'_>) {
        for slot in self.tiles.iter_mut().flat_map(|tile| &mut tile.slots) {
            for lane in 0..LANES {
                if slot.point[lane] != NONE {
                    slot.watch(lane, law, view);
                }
            }
        }
        self.stale = false;
    }
}

impl<R: Real> PointLanes<R> {
    fn empty() -> Self {
        let zero = Lanes([R::of(0.0); LANES]);
        let limit = Lanes([R::of(WATCH); LANES]);
        let (weight, taken, point) = (zero, zero, [NONE; LANES]);
        Self { at: [zero; 3], weight, limit, taken, damaged: false, own: None, flowed: None, point }
    }

    fn watch(&mut self, lane: usize, law: &PointLaw<'_>, view: &ParticlesMut<'_>) {
        let p = self.point[lane] as usize;
        let kind = view.kind[p] as usize;
        if kind > 0 {
            let first = || stiffness(&law.kinds[0].elastic).map(|x| Lanes([x; LANES]));
            let own = self.own.get_or_insert_with(|| Box::new(first()));
            for (lanes, x) in own.iter_mut().zip(stiffness(&law.kinds[kind].elastic)) {
                lanes.0[lane] = x;
            }
        }
        self.limit.0[lane] = R::of(law.limit(view, p));
        if view.flow.get(p).is_some_and(|state| state.history.strain > 0.0) {
            let none = || Box::new([Lanes([R::of(0.0); LANES]); 6]);
            let lanes = self.flowed.get_or_insert_with(none);
            for (lanes, &x) in lanes.iter_mut().zip(&view.flow[p].flowed) {
                lanes.0[lane] = R::of(x);
            }
        }
        self.taken.0[lane] = R::of(law.taken(view, p));
        self.damaged |= view.damage[p] > 0.0;
        if view.eroded[p] {
            self.weight.0[lane] = R::of(0.0);
        }
    }

    /// What has flowed in the stress, and which points flow no further.
    #[inline(always)]
    fn rests<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        effective: &mut Effective<V<S, R>>,
        shear: V<S, R>,
        limit: V<S, R>,
    ) -> <V<S, R> as SimdBase<S>>::Mask {
        let flowed = self.flowed.as_deref();
        let flowed = flowed.map(|m| [0, 1, 2, 3, 4, 5].map(|k| load(simd, &m[k], lane)));
        let equivalent = flowing::<S, R>(effective, flowed.as_ref(), shear);
        rests::<S, R>(simd, effective, equivalent, limit)
    }

    fn put(&mut self, lane: usize, x: &Vec3, spacing: &Vec3, volume: f64) {
        let stencil = Stencil::new(x, spacing);
        for axis in 0..3 {
            self.at[axis].0[lane] = R::of(-stencil.away[axis][1]);
        }
        self.weight.0[lane] = R::of(-volume);
    }
}

/// Displacements of the block's nodes from that of the first: rounding then goes by the strain of
/// the block, not by how far the body has moved.
#[inline(always)]
fn take<R: Real>(ids: &[u32], nodes: &Nodes, local: &mut Vec<Four<R>>) {
    let base = nodes.displacement[ids[0] as usize].to_array();
    local.clear();
    local.extend(ids.iter().map(|&id| {
        let u = nodes.displacement[id as usize].to_array();
        let mut from_base = [R::of(0.0); 4];
        for axis in 0..3 {
            let d = u[axis] - base[axis];
            from_base[axis] = R::of(if d.abs() < STILL { 0.0 } else { d });
        }
        from_base
    }));
}

/// Puts the nodes of elements side by side, less the first of each.
#[inline(always)]
fn fill<R: Real>(nodes: &[[u16; AROUND]; LANES], local: &[Four<R>], field: &mut NodeVectors<R>) {
    for (lane, around) in nodes.iter().enumerate() {
        let first = local[around[0] as usize];
        for (k, &node) in around.iter().enumerate() {
            let u = local[node as usize];
            for axis in 0..3 {
                field[k * 3 + axis].0[lane] = u[axis] - first[axis];
            }
        }
    }
}

/// Adds the forces of elements side by side to the nodes'.
#[inline(always)]
fn drain<R: Real>(nodes: &[[u16; AROUND]; LANES], field: &NodeVectors<R>, forces: &mut [Four<R>]) {
    for (lane, around) in nodes.iter().enumerate() {
        for (k, &node) in around.iter().enumerate() {
            let force = &mut forces[node as usize];
            for axis in 0..3 {
                force[axis] += field[k * 3 + axis].0[lane];
            }
        }
    }
}

/// The elements of one register of a tile.
#[inline(always)]
fn column<S: Simd, R: Real>(
    simd: S,
    tile: &mut Tile<R>,
    lane: usize,
    field: &NodeVectors<R>,
    forces: &mut NodeVectors<R>,
    cold: &mut Cold<'_, '_>,
) {
    let zero = V::<S, R>::splat(simd, R::of(0.0));
    for force in forces.iter_mut() {
        store(simd, zero, force, lane);
    }
    let first = stiffness(&cold.law.kinds[0].elastic).map(|x: R| V::<S, R>::splat(simd, x));
    let [hx, hy, hz] = [0, 1, 2].map(|axis| R::of(1.0 / cold.law.spacing[axis]));
    let flows = cold.law.flows();
    for slot in &mut tile.slots {
        let [x, y, z] = &slot.at;
        let at = [load(simd, x, lane), load(simd, y, lane), load(simd, z, lane)];
        let b = basis::<S, R>(at);
        let mut h = [[zero; 3]; 3];
        for (c, row) in h.iter_mut().enumerate() {
            let [x, y, z] = gather(simd, &b, field, c, lane);
            *row = [x * hx, y * hy, z * hz];
        }
        let own = match &slot.own {
            None => first,
            Some(own) => [0, 1, 2].map(|k| load(simd, &own[k], lane)),
        };
        let mut effective = second_piola::<S, R>(simd, &h, &own);
        let limit = load(simd, &slot.limit, lane);
        let mut idle = match flows {
            true => slot.rests(simd, lane, &mut effective, own[0], limit),
            false => idle::<S, R>(simd, &effective, limit),
        };
        let mut s = effective.stress;
        if slot.damaged && !flows {
            let taken = load(simd, &slot.taken, lane);
            let whole = V::<S, R>::splat(simd, R::of(1.0));
            let loose = V::<S, R>::splat(simd, R::of(LOOSE));
            let there = load(simd, &slot.weight, lane).simd_lt(zero);
            let away = taken.simd_ge(whole) & effective.square.simd_gt(loose) & there;
            idle &= away.select(zero, whole).simd_gt(zero);
            let left = weakened::<S, R>(simd, &effective.strain, &own, taken);
            for k in 0..6 {
                s[k] = taken.simd_gt(zero).select(left[k], s[k]);
            }
        }
        if !idle.all_true() {
            cold.weaken::<S, R>(slot, &tile.nodes, lane, idle, &effective, &mut s);
        }
        if slot.damaged {
            // The strain of a point that bears nothing any more may be too much for a number.
            let there = load(simd, &slot.weight, lane).simd_lt(zero);
            s = s.map(|stress| there.select(stress, zero));
        }
        let v = load(simd, &slot.weight, lane);
        let s = [s[0] * v, s[1] * v, s[2] * v, s[3] * v, s[4] * v, s[5] * v];
        let s = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
        for c in 0..3 {
            // A row of −V (I + H) S
            let x = s[c][0] + (h[c][0] * s[0][0] + h[c][1] * s[1][0] + h[c][2] * s[2][0]);
            let y = s[c][1] + (h[c][0] * s[0][1] + h[c][1] * s[1][1] + h[c][2] * s[2][1]);
            let z = s[c][2] + (h[c][0] * s[0][2] + h[c][1] * s[1][2] + h[c][2] * s[2][2]);
            scatter(simd, &b, [x * hx, y * hy, z * hz], forces, [c, lane]);
        }
    }
}

/// What the few points need whose damage may grow.
struct Cold<'a, 'b> {
    law: &'a PointLaw<'a>,
    nodes: &'a Nodes,
    ids: &'a [u32],
    view: &'a mut ParticlesMut<'b>,
    /// By lane, since registers of other widths take the lanes in another order.
    tallies: [DomainTally; LANES],
}

impl Cold<'_, '_> {
    /// Damage of those lanes where it may grow, point by point in f64.
    #[inline(never)]
    fn weaken<S: Simd, R: Real>(
        &mut self,
        slot: &mut PointLanes<R>,
        nodes: &[[u16; AROUND]; LANES],
        first: usize,
        idle: <V<S, R> as SimdBase<S>>::Mask,
        effective: &Effective<V<S, R>>,
        stress: &mut [V<S, R>; 6],
    ) {
        for (lane, around) in nodes.iter().enumerate().skip(first).take(V::<S, R>::LEN) {
            let k = lane - first;
            if idle.test(k) || slot.point[lane] == NONE {
                continue;
            }
            let p = slot.point[lane] as usize;
            if self.view.eroded[p] {
                // It is out of the account: what its nodes do on either side of it is no strain.
                (0..6).for_each(|i| stress[i][k] = R::of(0.0));
                continue;
            }
            let square = effective.square[k].wide();
            let crushed = square <= CRUSHED * CRUSHED;
            let tally = &mut self.tallies[lane];
            tally.crushed += u32::from(crushed);
            let strain = [0, 1, 2, 3, 4, 5].map(|i| effective.strain[i][k].wide());
            let x = self.view.reference[p];
            let rate = || {
                let velocity = |node: u16| self.nodes.velocity[self.ids[node as usize] as usize];
                let stencil = Stencil::new(&x, &self.law.spacing);
                let gain = self.law.spacing.map(|h| 4.0 / h);
                let (_, c) = gather_one(&around.map(velocity), &stencil, &gain);
                0.5 * (c + c.transpose()).norm()
            };
            let weakened = if self.view.damage[p] >= 1.0 && square > LOOSE {
                self.view.eroded[p] = true;
                tally.dissipated += self.law.held(self.view, p, &strain);
                [0.0; 6]
            } else if let Some(flowing) = self.law.flow(self.view, p, &strain, tally) {
                flowing
            } else {
                self.law.weaken(self.view, p, &strain, tally, rate)
            };
            for i in 0..6 {
                stress[i][k] = R::of(weakened[i]);
            }
            slot.watch(lane, self.law, self.view);
        }
    }
}
