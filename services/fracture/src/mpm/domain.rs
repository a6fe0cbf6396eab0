//! The time step: nodes to points, stress and damage, points to nodes.

mod bodies;
mod nodes;
mod sums;

pub(crate) use bodies::BodySurface;

use super::bonds::Bonds;
use super::contact::{NodeContacts, Shove};
use super::elastic::{LameParameters, green_strain};
use super::flow::{FlowLaw, FlowState};
use super::front::Front;
use super::grid::{BackgroundGrid, GridElement};
use super::kernel::{Kernel, MaterialLaw, PointLaw, least_share};
use super::node_split::{SplitChanges, split};
use super::spin::Spin;
use super::stencil::{Stencil, packed};
use super::tally::DomainTally;
use crate::damage::{DamageState, Softening};
use crate::particles::Particles;
use cullet_geometry::{Mat3, Vec3};
use cullet_model::tolerance::{REFRESH, SAFETY};
use cullet_model::{JohnsonCook, Material, PointPrecision};
use cullet_simd::SimdLevel;
use rayon::prelude::*;
use std::sync::Arc;
use wide::f64x4;

/// A strength, in those of the law, that no stress reaches.
const UNBREAKABLE: f64 = 1e12;

/// Nodes of a piece of work.
const NODES: usize = 512;

/// Velocity that holds at some nodes, for verification: place before the hit \[m\] to velocity
/// \[m/s\].
#[derive(Clone)]
pub struct PrescribedVelocity(pub Arc<dyn Fn(Vec3) -> Option<Vec3> + Send + Sync>);

impl std::fmt::Debug for PrescribedVelocity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("PrescribedVelocity")
    }
}

/// How many velocity fields a node has where a crack has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VelocityFields {
    /// One field: the sides of a crack stay welded at the nodes between them (F17).
    Single,
    /// As many fields at a node as sides that its points no longer connect.
    #[default]
    Split,
}

/// A body on its grid.
#[derive(Clone, Debug)]
pub struct Domain {
    /// The points.
    pub particles: Particles,
    /// Nodes and elements.
    pub grid: BackgroundGrid,
    /// Time step \[s\].
    pub step: f64,
    /// Simulated time \[s\].
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Prescribed node velocities; `None` for a free body.
    pub prescribed: Option<PrescribedVelocity>,
    /// What becomes of the velocity field at cracks.
    pub fields: VelocityFields,
    /// The frame's turning; `None` for one at rest.
    pub spin: Option<Spin>,
    cracks: Cracks,
    contact: NodeContacts,
    response: PointResponse,
    slot: Vec<u32>,
}

/// What cracks have parted, and where they may grow.
#[derive(Clone, Debug)]
struct Cracks {
    bonds: Bonds,
    front: Option<Front>,
    /// Points that broke since nodes were last split, by id.
    broken: Vec<u32>,
    /// How often nodes have been split.
    splits: u64,
    /// Steps between checks of what has parted.
    refresh: u64,
}

/// What the points bear.
#[derive(Clone, Debug)]
struct PointResponse {
    laws: Vec<MaterialLaw>,
    kernel: Kernel,
    /// A lighter node is pushed as if it had this mass \[kg\].
    least_mass: f64,
}

/// The motion of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion {
    /// Displacement \[m\].
    pub displacement: Vec3,
    /// H = F − I \[1\].
    pub displacement_gradient: Mat3,
    /// Velocity \[m/s\].
    pub velocity: Vec3,
    /// Its gradient by the place before the hit \[1/s\].
    pub velocity_gradient: Mat3,
}

/// Greatest stable step on a grid whose finest spacing is `spacing` \[m\], in \[s\]:
/// Δt ≤ 2/ω with ω² ≤ (4/h²)(3λ + 2μ)/ρ.
///
/// A point sees its nodes' mass shares m w and the gradients (4/h²) w d, and Σ w d dᵀ = h²/4 I: so
/// the greatest eigenvalue of each point alone is that of the elasticity tensor times 4/h²ρ, and no
/// assembly of points exceeds the greatest of its parts. Light nodes and copies do not lower it.
#[must_use]
pub fn stable_step(material: &Material, spacing: f64) -> f64 {
    let stiffness = (3.0 * material.lame() + 2.0 * material.shear()).max(2.0 * material.shear());
    spacing * (material.density / stiffness).sqrt()
}

impl Domain {
    /// Puts `particles` on a grid of `spacing` \[m\] along each axis.
    #[must_use]
    pub fn new(
        particles: Particles,
        material: &Material,
        softening: Softening,
        spacing: Vec3,
    ) -> Self {
        Self::mixed(particles, &[(*material, softening)], spacing)
    }

    /// Likewise, for points of several materials, each with its law: at least one.
    #[must_use]
    pub fn mixed(
        mut particles: Particles,
        materials: &[(Material, Softening)],
        spacing: Vec3,
    ) -> Self {
        let grid = BackgroundGrid::new(&mut particles, spacing);
        let bonds = Bonds::new(&particles, &spacing);
        let kernel = Kernel::new(&grid, &particles, PointPrecision::default(), SimdLevel::best());
        let mut domain = Self {
            step: SAFETY * least_step(materials, spacing.min()),
            particles,
            grid,
            time: 0.0,
            steps: 0,
            prescribed: None,
            fields: VelocityFields::default(),
            spin: None,
            cracks: Cracks { bonds, front: None, broken: Vec::new(), splits: 0, refresh: REFRESH },
            contact: NodeContacts::default(),
            response: PointResponse {
                laws: materials.iter().map(law_of).collect(),
                kernel,
                least_mass: 0.0,
            },
            slot: Vec::new(),
        };
        domain.locate();
        domain.follow_fronts(materials);
        domain
    }

    /// Does the points' pass in another precision and on another path of the processor.
    pub fn select(&mut self, precision: PointPrecision, simd_level: SimdLevel) {
        self.response.kernel = Kernel::new(&self.grid, &self.particles, precision, simd_level);
        let heaviest = self.grid.nodes.mass.iter().fold(0.0_f64, |most, &mass| most.max(mass));
        self.response.least_mass = least_share(precision) * heaviest;
    }

    /// Lets all points flow by `rule`, and tear with 2G_f/σ_yh as the plastic strain over which
    /// they do. All are of one material.
    pub fn let_flow(&mut self, material: &Material, rule: &JohnsonCook) {
        let spacing = self.grid.spacing.max();
        let stress = rule.hardening.yield_stress;
        let flow = FlowLaw {
            elastic: LameParameters::new(material),
            rule: *rule,
            density: material.density,
            tearing_strain: 2.0 * material.fracture_energy / (stress * spacing),
        };
        self.particles.flow = vec![FlowState::default(); self.particles.len()];
        self.response.laws.iter_mut().for_each(|law| law.flow = Some(flow));
    }

    /// Where the cap on strength is for cracks that grow, keeps track of where those are.
    fn follow_fronts(&mut self, materials: &[(Material, Softening)]) {
        if materials.iter().all(|(_, softening)| softening.strength_ratio >= 1.0) {
            return;
        }
        let ids = 0..self.particles.len() as u32;
        let places = ids.clone().map(|id| self.particles.reference[self.slot(id)]).collect();
        let speed = materials.iter().map(|row| row.0.rayleigh_speed()).fold(0.0, f64::max);
        self.cracks.front = Some(Front::new(places, self.grid.spacing.max(), speed));
        self.particles.front_time.fill(f64::INFINITY);
        let broken: Vec<u32> =
            ids.filter(|&id| self.particles.damage[self.slot(id)] >= 1.0).collect();
        broken.iter().for_each(|&id| self.open(id, 0.0));
    }

    /// Lets a crack that is at the point `id` at `time` \[s\] grow from there.
    pub fn open(&mut self, id: u32, time: f64) {
        let (slots, times) = (&self.slot, &mut self.particles.front_time);
        let kernel = &mut self.response.kernel;
        if let Some(front) = &self.cracks.front {
            front.around(id, |other, delay| {
                let slot = slots[other as usize];
                let known = &mut times[slot as usize];
                if *known == f64::INFINITY {
                    kernel.touch(slot);
                }
                *known = known.min(time + delay);
            });
        }
    }

    fn locate(&mut self) {
        self.slot.resize(self.particles.len(), 0);
        for (p, &id) in self.particles.id.iter().enumerate() {
            self.slot[id as usize] = p as u32;
        }
    }

    /// Where the point that was given as number `id` is now.
    #[must_use]
    pub fn slot(&self, id: u32) -> usize {
        self.slot[id as usize] as usize
    }

    /// The element of a point.
    #[must_use]
    fn element(&self, p: usize) -> &GridElement {
        let after = self.grid.elements.partition_point(|e| e.first as usize <= p);
        &self.grid.elements[after - 1]
    }

    /// Gives every node the velocity \[m/s\] that `velocity` has at its points, by mass.
    pub fn launch(&mut self, velocity: impl Fn(&Vec3) -> Vec3) {
        let nodes = &mut self.grid.nodes;
        nodes.velocity.fill(f64x4::splat(0.0));
        for element in &self.grid.elements {
            for p in element.points() {
                let x = &self.particles.reference[p];
                let momentum = velocity(x) * self.particles.mass(p);
                Stencil::new(x, &self.grid.spacing).visit(|k, weight, _| {
                    nodes.velocity[element.nodes[k] as usize] += packed(momentum * weight);
                });
            }
        }
        for (v, &mass) in nodes.velocity.iter_mut().zip(&nodes.mass) {
            *v *= f64x4::splat(inverse(mass));
        }
        self.contact.restart(nodes);
    }

    /// Moves every node by `displacement` \[m\] of its place before the hit.
    pub fn displace(&mut self, displacement: impl Fn(&Vec3) -> Vec3) {
        for n in 0..self.grid.nodes.len() {
            self.grid.nodes.displacement[n] = packed(displacement(&self.grid.place(n)));
        }
    }

    /// The piece of each whole point by id: points that no crack has parted have the same number;
    /// `None` for broken points.
    #[must_use]
    pub fn pieces(&self) -> Vec<Option<u32>> {
        self.cracks.bonds.pieces()
    }

    /// Cuts the bonds between points for which `apart` holds, either way round, given by the places
    /// of two points \[m\]: what was sawn before anything broke, whose sides do not rub.
    pub fn sever(&mut self, apart: impl Fn(&Vec3, &Vec3) -> bool) {
        self.cracks.bonds.sever(apart, &self.particles, &self.slot);
        let nodes: Vec<_> = (0..self.grid.nodes.len() as u32).map(|node| (node, true)).collect();
        self.split(&nodes);
        self.contact.saw(&self.grid.nodes);
        self.touch();
    }

    /// Cuts the bonds between points for which `apart` holds, within `reach` of `middle` \[m\]: a
    /// crack that comes now, whose sides rub.
    pub fn crack(&mut self, middle: &Vec3, reach: f64, apart: impl Fn(&Vec3, &Vec3) -> bool) {
        let near = |x: &Vec3| (x - middle).norm() < reach + self.grid.spacing.norm() * 2.0;
        let apart = |a: &Vec3, b: &Vec3| near(a) && apart(a, b);
        self.cracks.bonds.sever(apart, &self.particles, &self.slot);
        let nodes = (0..self.grid.nodes.len() as u32).map(|node| (node, true));
        let nodes: Vec<_> = nodes.filter(|node| near(&self.grid.place(node.0 as usize))).collect();
        self.split(&nodes);
    }

    /// Lets the sides of cracks rub, with Coulomb's coefficient μ \[1\].
    pub fn rub(&mut self, friction: f64) {
        self.contact.friction = friction;
    }

    /// Splits those of these nodes whose points no longer connect.
    fn split(&mut self, nodes: &[(u32, bool)]) {
        let (grid, particles) = (&mut self.grid, &mut self.particles);
        let changes: SplitChanges = split(&self.cracks.bonds, nodes, grid, particles, &self.slot);
        if changes.elements.is_empty() {
            return;
        }
        for &p in &changes.moved {
            self.slot[self.particles.id[p as usize] as usize] = p;
        }
        self.cracks.splits += 1;
        self.response.kernel.refresh(&self.grid, &self.particles, &changes.elements);
        self.touch();
    }

    /// Finds what may touch.
    fn touch(&mut self) {
        self.contact.find(&self.grid.nodes, &self.grid.spacing);
    }

    /// What passed between sides that met in the last step.
    pub(crate) fn shoves(&self) -> &[Shove] {
        self.contact.shoves()
    }

    /// How often nodes have been split.
    #[must_use]
    pub fn splits(&self) -> u64 {
        self.cracks.splits
    }

    /// Looks each so many steps at what has parted, at least one.
    pub fn check_cracks_every(&mut self, steps: u64) {
        self.cracks.refresh = steps.max(1);
    }

    /// Steps between checks of what has parted.
    #[must_use]
    pub fn crack_check_period(&self) -> u64 {
        self.cracks.refresh
    }

    /// Takes one step.
    pub fn advance(&mut self) -> DomainTally {
        let tally = self.strain();
        let fastest = self.accelerate();
        if let Some(spin) = self.spin {
            spin.push(&mut self.grid, self.step);
        }
        let collided = self.contact.resolve(&mut self.grid.nodes, self.step);
        self.displacement_step();
        self.time += self.step;
        self.steps += 1;
        if tally.broken > 0 {
            self.grow();
        }
        if self.fields == VelocityFields::Split
            && self.steps.is_multiple_of(self.cracks.refresh)
            && !self.cracks.broken.is_empty()
        {
            self.separate();
        }
        DomainTally { fastest, collided, ..tally }
    }

    /// Opens the way for cracks at the points that broke in this step.
    fn grow(&mut self) {
        let pairs = self.particles.damage_time.iter().zip(&self.particles.id);
        let broken: Vec<u32> =
            pairs.filter(|(time, _)| **time == self.time).map(|(_, &id)| id).collect();
        broken.iter().for_each(|&id| self.open(id, self.time));
        self.cracks.broken.extend(broken);
    }

    /// Parts the nodes that the cracks since the last time have passed.
    fn separate(&mut self) {
        let broken = std::mem::take(&mut self.cracks.broken);
        let mut nodes = self.cracks.bonds.grow(&broken, &self.grid, &self.particles, &self.slot);
        // Tears of what flows are as wide as cells are.
        nodes.iter_mut().for_each(|node| node.1 &= self.particles.flow.is_empty());
        self.split(&nodes);
    }

    /// Stress, damage and the forces of each element.
    fn strain(&mut self) -> DomainTally {
        let law = PointLaw {
            kinds: &self.response.laws,
            spacing: self.grid.spacing,
            time: self.time + self.step,
            step: self.step,
        };
        self.response.kernel.strain(&law, &self.grid, &mut self.particles)
    }

    /// Velocities after the step; the greatest |v|².
    fn accelerate(&mut self) -> f64 {
        let (grid, step, kernel) = (&mut self.grid, self.step, &self.response.kernel);
        let (spacing, prescribed, least) =
            (grid.spacing, self.prescribed.as_ref(), self.response.least_mass);
        let (mass, place) = (&grid.nodes.mass, &grid.nodes.place);
        let fastest: Vec<f64> = grid
            .nodes
            .velocity
            .par_chunks_mut(NODES)
            .enumerate()
            .map(|(chunk, velocities)| {
                let mut fastest = 0.0_f64;
                for (i, v) in velocities.iter_mut().enumerate() {
                    let n = chunk * NODES + i;
                    *v += kernel.force(n) * f64x4::splat(step * inverse(mass[n].max(least)));
                    if let Some(prescribed) = prescribed {
                        let x = Vec3::from(place[n].map(f64::from)).component_mul(&spacing);
                        if let Some(held) = prescribed.0(x) {
                            *v = packed(held);
                        }
                    }
                    fastest = fastest.max((*v * *v).reduce_add());
                }
                fastest
            })
            .collect();
        fastest.into_iter().fold(0.0, f64::max)
    }

    fn displacement_step(&mut self) {
        let step = f64x4::splat(self.step);
        let nodes = &mut self.grid.nodes;
        for (u, v) in nodes.displacement.iter_mut().zip(&nodes.velocity) {
            *u += *v * step;
        }
    }

    /// The motion of each point, in the order of the arrays.
    #[must_use]
    pub fn motions(&self) -> Vec<PointMotion> {
        let (nodes, gain) = (&self.grid.nodes, self.grid.spacing.map(|h| 4.0 / h));
        let mut motions = Vec::with_capacity(self.particles.len());
        for element in &self.grid.elements {
            let u = element.nodes.map(|n| nodes.displacement[n as usize]);
            let v = element.nodes.map(|n| nodes.velocity[n as usize]);
            for p in element.points() {
                let stencil = Stencil::new(&self.particles.reference[p], &self.grid.spacing);
                motions.push(PointMotion::gather(&u, &v, &stencil, &gain));
            }
        }
        motions
    }

    /// The second Piola–Kirchhoff stress of each point as it is weakened now \[Pa\].
    #[must_use]
    pub fn stresses(&self) -> Vec<[f64; 6]> {
        let motions = self.motions();
        let points = motions.iter().enumerate();
        points.map(|(p, motion)| self.stress(p, &motion.displacement_gradient)).collect()
    }

    fn stress(&self, p: usize, h: &Mat3) -> [f64; 6] {
        if self.particles.eroded[p] {
            return [0.0; 6];
        }
        let law = &self.response.laws[self.particles.kind[p] as usize];
        if let Some(flow) = &law.flow {
            // A step without end flows at the slowest rate.
            return flow.respond(&green_strain(h), self.particles.flow[p], f64::INFINITY).stress;
        }
        let state = DamageState {
            damage: self.particles.damage[p],
            strength: UNBREAKABLE,
            shielded: self.particles.shielded[p],
            lone: 1.0,
        };
        law.softening.respond(&green_strain(h), state).stress
    }

    /// Whether every displacement and velocity is a number (F76).
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let sum = |list: &[f64x4]| list.iter().fold(0.0, |s, v| s + v.reduce_add());
        let nodes = &self.grid.nodes;
        (sum(&nodes.displacement) + sum(&nodes.velocity)).is_finite()
    }
}

fn law_of((material, softening): &(Material, Softening)) -> MaterialLaw {
    MaterialLaw { elastic: LameParameters::new(material), softening: *softening, flow: None }
}

fn least_step(materials: &[(Material, Softening)], spacing: f64) -> f64 {
    let steps = materials.iter().map(|row| stable_step(&row.0, spacing));
    steps.fold(f64::INFINITY, f64::min)
}

fn inverse(mass: f64) -> f64 {
    if mass > 0.0 { 1.0 / mass } else { 0.0 }
}
