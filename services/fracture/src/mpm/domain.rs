//! The time step: points, blocks, arenas, nodes.

use super::blocks::{ARENA, ARENA_EDGE, Blocks, EDGE, LAST_CELL, NODES, NONE};
use super::blocks::{arena_origin, base_cell, offset};
use super::elastic::{CRUSHED, Elastic, left_strain, volume_change};
use super::front::Front;
use super::kernel::{Share, Stencil, gather, scatter};
use crate::damage::{Softening, State};
use crate::material::Material;
use crate::particles::{Particles, View};
use cullet_geometry::{Mat3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;
use wide::f64x4;

/// Step over h/c_d. The 1-D limits are 1.00 to 1.26 (1 to 3 points a cell, free ends); damage,
/// jitter and three dimensions ask for a margin, and a much smaller step damps waves (F05, F06).
pub const COURANT: f64 = 0.45;

/// Node mass, in particle masses, below which a node carries no velocity (F04): the weight of a
/// point that touches a node by a hundred-millionth of a cell. Larger values lose momentum.
const LIGHT_NODE: f64 = 1e-15;

/// Velocity that holds at some nodes, for verification: position \[m\] to velocity \[m/s\].
#[derive(Clone)]
pub struct Grip(pub Arc<dyn Fn(Vec3) -> Option<Vec3> + Send + Sync>);

impl std::fmt::Debug for Grip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Grip")
    }
}

/// A body on its grid.
#[derive(Clone, Debug)]
pub struct Domain {
    /// The points.
    pub particles: Particles,
    /// Grid spacing h \[m\].
    pub spacing: f64,
    /// Time step \[s\].
    pub step: f64,
    /// Simulated time \[s\].
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Prescribed node velocities; `None` for a free body.
    pub grip: Option<Grip>,
    elastic: Elastic,
    softening: Softening,
    front: Option<Front>,
    blocks: Blocks,
    arenas: Vec<f64x4>,
    nodes: Vec<f64x4>,
    slot: Vec<u32>,
    lightest: f64,
}

/// What a step noticed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Energy lost to damage \[J\].
    pub dissipated: f64,
    /// Points whose damage grew.
    pub grown: u32,
    /// Points that reached full damage.
    pub broken: u32,
    /// Points with J ≤ 0.2, set back to 0.2 (F07).
    pub crushed: u32,
    /// Points that left their block's slack: the blocks are made anew.
    pub strayed: u32,
    /// Greatest |v|² \[m²/s²\].
    pub fastest: f64,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.dissipated += other.dissipated;
        self.grown += other.grown;
        self.broken += other.broken;
        self.crushed += other.crushed;
        self.strayed += other.strayed;
        self.fastest = self.fastest.max(other.fastest);
    }
}

impl Domain {
    /// Puts `particles` on a grid of `spacing` \[m\].
    #[must_use]
    pub fn new(
        mut particles: Particles,
        material: &Material,
        softening: Softening,
        spacing: f64,
    ) -> Self {
        let blocks = Blocks::bin(&mut particles, spacing);
        let mut domain = Self {
            particles,
            spacing,
            step: COURANT * spacing / material.pressure_speed(),
            time: 0.0,
            steps: 0,
            grip: None,
            elastic: Elastic::new(material),
            softening,
            front: None,
            blocks,
            arenas: Vec::new(),
            nodes: Vec::new(),
            slot: Vec::new(),
            lightest: 0.0,
        };
        let lightest = domain.particles.volume.iter().fold(f64::INFINITY, |m, v| m.min(*v));
        domain.lightest = material.density * lightest;
        domain.allocate();
        domain.watch(material);
        domain
    }

    /// Where the cap on strength is for cracks that grow, keeps track of where those are.
    fn watch(&mut self, material: &Material) {
        if self.softening.strength_ratio >= 1.0 {
            return;
        }
        let ids = 0..self.particles.len() as u32;
        let places = ids.clone().map(|id| self.particles.reference[self.slot(id)]).collect();
        self.front = Some(Front::new(places, self.spacing, material.rayleigh_speed()));
        self.particles.front_time.fill(f64::INFINITY);
        let broken: Vec<u32> =
            ids.filter(|&id| self.particles.damage[self.slot(id)] >= 1.0).collect();
        broken.iter().for_each(|&id| self.open(id, 0.0));
    }

    /// Lets a crack that is at the point `id` at `time` \[s\] grow from there.
    pub fn open(&mut self, id: u32, time: f64) {
        let (slots, times) = (&self.slot, &mut self.particles.front_time);
        if let Some(front) = &self.front {
            front.around(id, |other, delay| {
                let known = &mut times[slots[other as usize] as usize];
                *known = known.min(time + delay);
            });
        }
    }

    fn allocate(&mut self) {
        let zero = f64x4::splat(0.0);
        self.arenas.clear();
        self.arenas.resize(self.blocks.filled.len() * ARENA, zero);
        self.nodes.clear();
        self.nodes.resize(self.blocks.nodes.len() * NODES, zero);
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

    /// Pushes one point with `impulse` \[N·s\]; returns the work done \[J\].
    pub fn push(&mut self, id: u32, impulse: Vec3) -> f64 {
        let p = self.slot(id);
        let mass = self.particles.mass(p);
        let velocity = &mut self.particles.velocity[p];
        let work = impulse.dot(velocity) + 0.5 * impulse.norm_squared() / mass;
        *velocity += impulse / mass;
        work
    }

    /// Takes one step.
    pub fn advance(&mut self) -> Tally {
        self.scatter();
        self.sum();
        let tally = self.update();
        self.time += self.step;
        self.steps += 1;
        if tally.broken > 0 && self.front.is_some() {
            self.grow();
        }
        if tally.strayed > 0 {
            self.blocks = Blocks::bin(&mut self.particles, self.spacing);
            self.allocate();
        }
        tally
    }

    /// Opens the way for cracks at the points that broke in this step.
    fn grow(&mut self) {
        let pairs = self.particles.damage_time.iter().zip(&self.particles.id);
        let broken: Vec<u32> =
            pairs.filter(|(time, _)| **time == self.time).map(|(_, &id)| id).collect();
        broken.iter().for_each(|&id| self.open(id, self.time));
    }

    fn scatter(&mut self) {
        let (h, inverse) = (self.spacing, 1.0 / self.spacing);
        let impulse = self.step * 4.0 / (h * h);
        let (particles, blocks) = (&self.particles, &self.blocks);
        self.arenas.par_chunks_mut(ARENA).enumerate().for_each(|(b, arena)| {
            arena.fill(f64x4::splat(0.0));
            let origin = arena_origin(blocks.filled[b]);
            for p in blocks.starts[b] as usize..blocks.starts[b + 1] as usize {
                let stencil = Stencil::new(&particles.position[p], origin, h, inverse);
                scatter(arena, &stencil, &share(particles, p, impulse));
            }
        });
    }

    fn sum(&mut self) {
        let light = LIGHT_NODE * self.lightest;
        let (blocks, arenas, grip, h) = (&self.blocks, &self.arenas, &self.grip, self.spacing);
        self.nodes.par_chunks_mut(NODES).enumerate().for_each(|(n, nodes)| {
            nodes.fill(f64x4::splat(0.0));
            for (o, &b) in blocks.filled_around[n].iter().enumerate() {
                if b != NONE {
                    let arena = &arenas[b as usize * ARENA..(b as usize + 1) * ARENA];
                    // The filled block lies at +offset from the nodes: the nodes at −offset
                    // from it.
                    overlap(26 - o, |node, slot| nodes[node] += arena[slot]);
                }
            }
            for value in nodes.iter_mut() {
                let mass = value.to_array()[0];
                let inverse = if mass > light { 1.0 / mass } else { 0.0 };
                *value *= f64x4::splat(inverse);
            }
            if let Some(grip) = grip {
                hold(nodes, blocks.nodes[n], h, grip);
            }
        });
    }

    fn update(&mut self) -> Tally {
        let law = Law {
            elastic: self.elastic,
            softening: self.softening,
            spacing: self.spacing,
            inverse: 1.0 / self.spacing,
            step: self.step,
            time: self.time + self.step,
            lone: 1.0 / self.softening.strength_ratio,
        };
        let (blocks, nodes) = (&self.blocks, &self.nodes);
        let mut views = self.particles.views(&blocks.starts);
        let tallies: Vec<Tally> = views
            .par_iter_mut()
            .zip(self.arenas.par_chunks_mut(ARENA))
            .enumerate()
            .map(|(b, (view, arena))| {
                for (o, &n) in blocks.nodes_of[b].iter().enumerate() {
                    let from = &nodes[n as usize * NODES..(n as usize + 1) * NODES];
                    overlap(o, |node, slot| arena[slot] = from[node]);
                }
                law.block(view, arena, arena_origin(blocks.filled[b]))
            })
            .collect();
        tallies.iter().fold(Tally::default(), |mut sum, tally| {
            sum.add(tally);
            sum
        })
    }

    /// Elastic energy \[J\], to second order in the strain.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let particles = &self.particles;
        let pairs = particles.stress.iter().zip(&particles.displacement_gradient);
        pairs
            .zip(&particles.volume)
            .map(|((s, h), volume)| {
                // ½ τ : ½(b − I)
                let b = left_strain(h);
                let normal = s[0] * b[0] + s[1] * b[1] + s[2] * b[2];
                0.25 * volume * (normal + 2.0 * (s[3] * b[3] + s[4] * b[4] + s[5] * b[5]))
            })
            .sum()
    }

    /// Whether every position and velocity is a number (F76).
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let sum = |list: &[Vec3]| list.iter().fold(0.0, |s, v| s + v.x + v.y + v.z);
        (sum(&self.particles.position) + sum(&self.particles.velocity)).is_finite()
    }
}

/// Calls `visit(node, slot)` for each node of a block of nodes that lies in the arena of a filled
/// block, the nodes at the `o`-th offset from the filled block; a node is given by its place in its
/// block and its place in the arena.
#[inline]
fn overlap(o: usize, mut visit: impl FnMut(usize, usize)) {
    let range = |d: i32| match d {
        -1 => (EDGE - 1..EDGE, 0),
        0 => (0..EDGE, 1),
        _ => (0..EDGE - 1, EDGE + 1),
    };
    let [x, y, z] = offset(o).map(range);
    for i in x.0.clone() {
        for j in y.0.clone() {
            for k in z.0.clone() {
                let slot =
                    |at: usize, axis: &(std::ops::Range<usize>, usize)| at - axis.0.start + axis.1;
                let (a, b, c) = (slot(i, &x), slot(j, &y), slot(k, &z));
                visit((i * EDGE + j) * EDGE + k, (a * ARENA_EDGE + b) * ARENA_EDGE + c);
            }
        }
    }
}

/// [m, mv] and the columns of [0, mC − Δt V (4/h²) τ]; `impulse` is Δt 4/h².
#[inline]
fn share(particles: &Particles, p: usize, impulse: f64) -> Share {
    let (m, v, c) = (particles.mass(p), &particles.velocity[p], &particles.affine[p]);
    let impulse = impulse * particles.volume[p];
    let s = &particles.stress[p];
    let column = |a: f64, b: f64, c: f64| f64x4::new([0.0, a, b, c]);
    let f = |c: f64, s: f64| m * c - impulse * s;
    Share {
        constant: f64x4::new([m, m * v.x, m * v.y, m * v.z]),
        slope: [
            column(f(c[(0, 0)], s[0]), f(c[(1, 0)], s[3]), f(c[(2, 0)], s[5])),
            column(f(c[(0, 1)], s[3]), f(c[(1, 1)], s[1]), f(c[(2, 1)], s[4])),
            column(f(c[(0, 2)], s[5]), f(c[(1, 2)], s[4]), f(c[(2, 2)], s[2])),
        ],
    }
}

fn hold(nodes: &mut [f64x4], block: [i32; 3], h: f64, grip: &Grip) {
    for (n, value) in nodes.iter_mut().enumerate() {
        let local = [n / (EDGE * EDGE), n / EDGE % EDGE, n % EDGE];
        let at = |axis: usize| (block[axis] * EDGE as i32 + local[axis] as i32) as f64 * h;
        if let Some(v) = grip.0(Vec3::new(at(0), at(1), at(2))) {
            *value = f64x4::new([1.0, v.x, v.y, v.z]);
        }
    }
}

/// What the update of a block needs to know.
struct Law {
    elastic: Elastic,
    softening: Softening,
    spacing: f64,
    inverse: f64,
    step: f64,
    time: f64,
    /// Strength away from cracks over strength at them \[1\].
    lone: f64,
}

impl Law {
    fn block(&self, view: &mut View<'_>, arena: &[f64x4], origin: [i32; 3]) -> Tally {
        let gain = 4.0 * self.inverse * self.inverse;
        let mut tally = Tally::default();
        for p in 0..view.position.len() {
            let stencil = Stencil::new(&view.position[p], origin, self.spacing, self.inverse);
            let (v, c) = gather(arena, &stencil, gain);
            view.velocity[p] = v;
            view.affine[p] = c;
            view.position[p] += v * self.step;
            let h = &mut view.displacement_gradient[p];
            // F ← (I + Δt C) F, so H ← H + Δt C (I + H)
            *h += (c + c * *h) * self.step;
            if volume_change(h) <= CRUSHED - 1.0 {
                *h = Mat3::identity() * (libm::cbrt(CRUSHED) - 1.0);
                tally.crushed += 1;
            }
            self.damage(view, p, &mut tally);
            tally.fastest = tally.fastest.max(v.norm_squared());
            let cell = base_cell(&view.position[p], self.inverse);
            let inside = (0..3).all(|a| (0..=LAST_CELL).contains(&(cell[a] - origin[a])));
            tally.strayed += u32::from(!inside);
        }
        tally
    }

    #[inline]
    fn damage(&self, view: &mut View<'_>, p: usize, tally: &mut Tally) {
        let effective = self.elastic.kirchhoff(&view.displacement_gradient[p]);
        let lone = if self.time < view.front_time[p] { self.lone } else { 1.0 };
        let state = State {
            damage: view.damage[p],
            strength: view.strength[p] * lone,
            shielded: view.shielded[p],
            sudden: lone > 1.0,
        };
        let response = self.softening.respond(&effective, state);
        view.stress[p] = response.stress;
        if response.damage > state.damage {
            view.damage[p] = response.damage;
            if state.damage <= 0.0 {
                let c = view.affine[p];
                view.onset_rate[p] = 0.5 * (c + c.transpose()).norm();
            }
            tally.grown += 1;
            tally.dissipated += response.dissipated * view.volume[p];
            if response.damage >= 1.0 {
                view.damage_time[p] = self.time;
                tally.broken += 1;
            }
        }
    }
}
