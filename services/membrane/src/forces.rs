//! Forces on all points, gathered over the bonds of each in a fixed order: both ends of a bond
//! compute the same bits, and no sum depends on the number of threads.

use crate::air;
use crate::bending::{BendingStencils, curvature_form};
use crate::bonds::MembraneBonds;
use crate::grips::FREE;
use crate::law::{BondMemory, generalised, generalised_slope, stretched};
use crate::lips::LipPairs;
use crate::table::BondTable;
use cullet_geometry::Vec3;
use cullet_model::{MembraneLaw, SheetAir};

/// Points that one task takes. The split of sums depends on it, and on nothing else.
const TASK: usize = 512;

/// What forces depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceInput<'a> {
    pub(crate) law: MembraneLaw,
    pub(crate) bonds: &'a MembraneBonds,
    pub(crate) table: &'a BondTable,
    pub(crate) stencils: &'a BendingStencils,
    pub(crate) lips: &'a LipPairs,
    pub(crate) places: &'a [Vec3],
    pub(crate) velocities: &'a [Vec3],
    /// Mass that weighs, and inertia \[kg\].
    pub(crate) masses: &'a [[f64; 2]],
    pub(crate) areas: &'a [f64],
    /// B \[J\] and ν \[1\]; no bending where B is 0.
    pub(crate) bending: [f64; 2],
    /// Λ \[N/m\].
    pub(crate) dilatation: f64,
    /// Of a bond: c = `damping` k/ξ² \[s\].
    pub(crate) damping: f64,
    pub(crate) gravity: Vec3,
    /// The air, where it acts, and its wind now.
    pub(crate) air: Option<(&'a SheetAir, Vec3)>,
    /// Forces of rigid bodies \[N\].
    pub(crate) touch: &'a [Vec3],
    /// Grip of each point.
    pub(crate) holders: &'a [u32],
    /// Points that are not simulated.
    pub(crate) frozen: &'a [bool],
    /// Whether its bonds may not break.
    pub(crate) guarded: &'a [bool],
    /// Velocity of each grip after the step \[m/s\].
    pub(crate) led: &'a [Vec3],
    pub(crate) dt: f64,
}

/// What a first pass leaves for the second, by point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PointTerms {
    /// A B ∂(½q)/∂κ \[J/m · …\].
    pub(crate) moments: [Vec3; 3],
    /// Area vector of the upper side \[m²\].
    pub(crate) area: Vec3,
    /// 2ΛAθ/Σk \[1\].
    pub(crate) dilatation: f64,
}

/// What a step changes, of some points and their bonds.
#[derive(Debug)]
pub(crate) struct ForceRows<'a> {
    /// Number of the first of them.
    pub(crate) first: usize,
    pub(crate) damage: &'a mut [f64],
    /// Of a foil; empty otherwise.
    pub(crate) plastic: &'a mut [f64],
    /// Likewise.
    pub(crate) flowed: &'a mut [f64],
    pub(crate) terms: &'a mut [PointTerms],
    /// Velocities after the step \[m/s\].
    pub(crate) after: &'a mut [Vec3],
    /// Impulses of grips \[N·s\].
    pub(crate) held: &'a mut [Vec3],
    /// Points of which a bond has broken.
    pub(crate) torn: &'a mut [bool],
}

/// What a step did, in sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StepSums {
    pub(crate) broken: f64,
    pub(crate) plastic: f64,
    pub(crate) damped: f64,
    pub(crate) air: f64,
    pub(crate) grips: f64,
    pub(crate) gravity: f64,
    pub(crate) bodies: f64,
    /// Impulses from outside \[N·s\].
    pub(crate) impulse: Vec3,
    /// Sum of the sizes of all changes of momentum \[N·s\].
    pub(crate) exchanged: f64,
    /// Bonds broken, each counted at both ends.
    pub(crate) breaks: u32,
}

impl StepSums {
    pub(crate) fn plus(mut self, other: Self) -> Self {
        self.broken += other.broken;
        self.plastic += other.plastic;
        self.damped += other.damped;
        self.air += other.air;
        self.grips += other.grips;
        self.gravity += other.gravity;
        self.bodies += other.bodies;
        self.impulse += other.impulse;
        self.exchanged += other.exchanged;
        self.breaks += other.breaks;
        self
    }
}

impl<'a> ForceRows<'a> {
    /// The same once more.
    pub(crate) fn again(&mut self) -> ForceRows<'_> {
        ForceRows {
            first: self.first,
            damage: &mut *self.damage,
            plastic: &mut *self.plastic,
            flowed: &mut *self.flowed,
            terms: &mut *self.terms,
            after: &mut *self.after,
            held: &mut *self.held,
            torn: &mut *self.torn,
        }
    }

    /// Two halves, the first of `count` points.
    fn split(self, bonds: &MembraneBonds, count: usize) -> (Self, Self) {
        let middle = self.first + count;
        let slots = (bonds.starts[middle] - bonds.starts[self.first]) as usize;
        let (damage, damage_after) = self.damage.split_at_mut(slots);
        let flows = slots.min(self.plastic.len());
        let (plastic, plastic_after) = self.plastic.split_at_mut(flows);
        let (flowed, flowed_after) = self.flowed.split_at_mut(flows);
        let (terms, terms_after) = self.terms.split_at_mut(count.min(self.terms.len()));
        let (after, after_after) = self.after.split_at_mut(count);
        let (held, held_after) = self.held.split_at_mut(count);
        let (torn, torn_after) = self.torn.split_at_mut(count);
        let first = self.first;
        (
            Self { first, damage, plastic, flowed, terms, after, held, torn },
            Self {
                first: middle,
                damage: damage_after,
                plastic: plastic_after,
                flowed: flowed_after,
                terms: terms_after,
                after: after_after,
                held: held_after,
                torn: torn_after,
            },
        )
    }
}

/// Runs a pass over all points in tasks of fixed size and adds up what they did, in a fixed order.
pub(crate) fn pass(
    bonds: &MembraneBonds,
    rows: ForceRows<'_>,
    task: &(impl Fn(ForceRows<'_>) -> StepSums + Sync),
) -> StepSums {
    let count = rows.after.len();
    if count <= TASK {
        return task(rows);
    }
    let half = count.div_ceil(2 * TASK) * TASK;
    let (low, high) = rows.split(bonds, half);
    let (a, b) = rayon::join(|| pass(bonds, low, task), || pass(bonds, high, task));
    a.plus(b)
}

/// First pass: curvatures, area vectors, and where there is a dilatation, what bonds remember.
pub(crate) fn find_terms(input: &ForceInput<'_>, rows: ForceRows<'_>) -> StepSums {
    match input.law {
        MembraneLaw::Brittle => terms_of(MembraneLaw::Brittle, input, rows),
        MembraneLaw::Foil => terms_of(MembraneLaw::Foil, input, rows),
        MembraneLaw::Rubber => terms_of(MembraneLaw::Rubber, input, rows),
    }
}

#[inline(always)]
fn terms_of(law: MembraneLaw, input: &ForceInput<'_>, rows: ForceRows<'_>) -> StepSums {
    let mut sums = StepSums::default();
    let [stiffness, poisson] = input.bending;
    let base = input.bonds.starts[rows.first] as usize;
    for k in 0..rows.terms.len() {
        let i = rows.first + k;
        let mut found = PointTerms::default();
        if input.frozen[i] {
            rows.terms[k] = found;
            continue;
        }
        if stiffness > 0.0 {
            let kappa = input.stencils.curvature(i, input.places);
            let scale = input.areas[i] * stiffness * input.table.softness[i];
            found.moments = curvature_form(&kappa, poisson).1.map(|m| m * scale);
        }
        if input.air.is_some() {
            let [x, y] = input.stencils.slopes(i, input.places);
            found.area = x.cross(&y) * input.areas[i];
        }
        if input.dilatation != 0.0 {
            let mut memories = MemoryRows {
                damage: &mut *rows.damage,
                plastic: &mut *rows.plastic,
                flowed: &mut *rows.flowed,
                base,
            };
            let (theta, lost) = dilate(law, input, i, &mut memories, &mut sums, &mut rows.torn[k]);
            let lambda = input.dilatation * input.table.softness[i] * input.areas[i];
            sums.broken += lambda * (theta * lost + 0.5 * lost * lost);
            found.dilatation = 2.0 * lambda * theta / input.table.sums[i];
        }
        rows.terms[k] = found;
    }
    sums
}

/// What bonds of some points remember.
struct MemoryRows<'a> {
    damage: &'a mut [f64],
    plastic: &'a mut [f64],
    flowed: &'a mut [f64],
    /// Number of the first bond.
    base: usize,
}

impl MemoryRows<'_> {
    #[inline(always)]
    fn get(&self, law: MembraneLaw, b: usize) -> BondMemory {
        let slot = b - self.base;
        let damage = self.damage[slot];
        match law {
            MembraneLaw::Foil => {
                BondMemory { damage, plastic: self.plastic[slot], flowed: self.flowed[slot] }
            }
            _ => BondMemory { damage, ..BondMemory::default() },
        }
    }

    #[inline(always)]
    fn set(&mut self, law: MembraneLaw, b: usize, memory: BondMemory) {
        let slot = b - self.base;
        self.damage[slot] = memory.damage;
        if law == MembraneLaw::Foil {
            self.plastic[slot] = memory.plastic;
            self.flowed[slot] = memory.flowed;
        }
    }
}

/// Stretch that a bond's dilatation counts, by its memory: what is not broken and has not flowed.
#[inline(always)]
pub(crate) fn counted(g: f64, memory: BondMemory) -> f64 {
    match memory.damage >= 1.0 {
        true => 0.0,
        false => (1.0 - memory.damage) * (g - memory.plastic),
    }
}

/// θ of a point, and what it has lost of it in this step by damage and flow.
#[inline(always)]
fn dilate(
    law: MembraneLaw,
    input: &ForceInput<'_>,
    i: usize,
    memories: &mut MemoryRows<'_>,
    sums: &mut StepSums,
    torn: &mut bool,
) -> (f64, f64) {
    let (mut now, mut before) = (0.0, 0.0);
    for b in input.bonds.of(i) {
        let mut memory = memories.get(law, b);
        if memory.damage >= 1.0 {
            continue;
        }
        let j = input.bonds.ends[b] as usize;
        let length = (input.places[j] - input.places[i]).norm();
        let g = generalised(law, length * input.table.rest[b]);
        let k = input.table.stiffness[b];
        before += k * counted(g, memory);
        let fails = !(input.guarded[i] || input.guarded[j]);
        let did = stretched(law, g, &mut memory, input.table.limits[b], fails);
        sums.broken += 0.5 * k * did.broken;
        sums.plastic += 0.5 * k * did.plastic;
        if memory.damage >= 1.0 {
            sums.breaks += 1;
            *torn = true;
        }
        now += k * counted(g, memory);
        memories.set(law, b, memory);
    }
    let scale = 2.0 / input.table.sums[i];
    (scale * now, scale * (before - now))
}

/// Second pass: forces and the velocities after them.
pub(crate) fn kick(input: &ForceInput<'_>, terms: &[PointTerms], rows: ForceRows<'_>) -> StepSums {
    match input.law {
        MembraneLaw::Brittle => kick_of(MembraneLaw::Brittle, input, terms, rows),
        MembraneLaw::Foil => kick_of(MembraneLaw::Foil, input, terms, rows),
        MembraneLaw::Rubber => kick_of(MembraneLaw::Rubber, input, terms, rows),
    }
}

#[inline(always)]
fn kick_of(
    law: MembraneLaw,
    input: &ForceInput<'_>,
    terms: &[PointTerms],
    rows: ForceRows<'_>,
) -> StepSums {
    let mut sums = StepSums::default();
    let ForceRows { first, damage, plastic, flowed, after, held: grips, torn, .. } = rows;
    let base = input.bonds.starts[first] as usize;
    let mut memories = MemoryRows { damage, plastic, flowed, base };
    for k in 0..after.len() {
        let i = first + k;
        if input.frozen[i] {
            after[k] = Vec3::zeros();
            continue;
        }
        let (mut force, damper) =
            bond_force(law, input, terms, i, &mut memories, &mut sums, &mut torn[k]);
        if input.bending[0] > 0.0 {
            force += bending_force(input, terms, i);
        }
        let (lips, propped) = input.lips.force(i, input.places, input.frozen);
        force += lips;
        let weight = input.gravity * input.masses[i][0];
        let touch = input.touch[i];
        let mut change = (force + damper + weight + touch) * input.dt;
        let mass = input.masses[i][1];
        let v = input.velocities[i];
        let mut blown = Vec3::zeros();
        if let Some((air, wind)) = input.air {
            // The drag of what the other forces leave.
            let relative = v + change / mass - wind;
            blown = air::impulse(air, terms[i].area, relative, mass, input.dt);
            change += blown;
        }
        let mut next = v + change / mass;
        let mut held = Vec3::zeros();
        if input.holders[i] != FREE {
            next = input.led[input.holders[i] as usize];
            held = (next - v) * mass - change;
            grips[k] = held;
        }
        let middle = 0.5 * (v + next);
        sums.damped -= damper.dot(&middle) * input.dt;
        sums.gravity += weight.dot(&middle) * input.dt;
        sums.bodies += touch.dot(&middle) * input.dt;
        sums.air += blown.dot(&middle);
        sums.grips += held.dot(&middle);
        sums.impulse += (weight + touch + propped) * input.dt + blown + held;
        sums.exchanged += change.norm() + held.norm();
        after[k] = next;
    }
    sums
}

/// Force of a point's bonds, and of their dashpots \[N\].
#[inline(always)]
fn bond_force(
    law: MembraneLaw,
    input: &ForceInput<'_>,
    terms: &[PointTerms],
    i: usize,
    memories: &mut MemoryRows<'_>,
    sums: &mut StepSums,
    torn: &mut bool,
) -> (Vec3, Vec3) {
    let dilates = input.dilatation != 0.0;
    let (mut force, mut damper) = (Vec3::zeros(), Vec3::zeros());
    for b in input.bonds.of(i) {
        let mut memory = memories.get(law, b);
        if memory.damage >= 1.0 {
            continue;
        }
        let j = input.bonds.ends[b] as usize;
        let off = input.places[j] - input.places[i];
        let length = off.norm();
        let (rest, k) = (input.table.rest[b], input.table.stiffness[b]);
        let stretch = length * rest;
        let g = generalised(law, stretch);
        let mut tension;
        if dilates {
            let left = if g > 0.0 { 1.0 - memory.damage } else { 1.0 };
            tension = left * (g - memory.plastic);
            let both = terms[i].dilatation + terms[j].dilatation;
            tension += (1.0 - memory.damage) * both;
        } else {
            let fails = !(input.guarded[i] || input.guarded[j]);
            let did = stretched(law, g, &mut memory, input.table.limits[b], fails);
            if did.broken > 0.0 || did.plastic > 0.0 {
                sums.broken += 0.5 * k * did.broken;
                sums.plastic += 0.5 * k * did.plastic;
                if memory.damage >= 1.0 {
                    sums.breaks += 1;
                    *torn = true;
                }
                memories.set(law, b, memory);
            }
            tension = did.tension;
        }
        let along = off / length;
        force += along * (k * tension * generalised_slope(law, stretch) * rest);
        let closing = (input.velocities[j] - input.velocities[i]).dot(&along);
        let c = input.damping * k * (1.0 - memory.damage) * (rest * rest);
        damper += along * (c * closing);
    }
    (force, damper)
}

/// Force of bending: what a point's own curvature and those of its neighbours give it \[N\].
#[inline(always)]
fn bending_force(input: &ForceInput<'_>, terms: &[PointTerms], i: usize) -> Vec3 {
    let stencils = input.stencils;
    let own = &terms[i].moments;
    let mut force = Vec3::zeros();
    for n in stencils.of(i) {
        let [xx, xy, yy] = stencils.terms[n].curvature;
        force += own[0] * xx + own[1] * xy + own[2] * yy;
        let [xx, xy, yy] = stencils.terms[stencils.twins[n] as usize].curvature;
        let other = &terms[stencils.ends[n] as usize].moments;
        force -= other[0] * xx + other[1] * xy + other[2] * yy;
    }
    force
}
