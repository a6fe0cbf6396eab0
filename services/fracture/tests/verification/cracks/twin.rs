//! A plain twin of the solver, to compare ways of parting the velocity field: the same points,
//! law and frame, APIC transfers each step, and the compatible pairs of CPIC (Hu et al. 2018).
//!
//! CPIC wants the crack's surface beforehand: the twin is given the right plane, whole, and opens
//! it where the solver's own discs would: half a spacing around points that broke, looked at as
//! often. No crack can be better for it.

use super::specimen::{H, STONE, Specimen};
use cullet_fracture::damage::{DamageState, Softening};
use cullet_fracture::mpm::domain::{PointMotion, PrescribedVelocity, stable_step};
use cullet_fracture::mpm::elastic::{green_strain, matrix};
use cullet_fracture::mpm::grid::AROUND;
use cullet_fracture::mpm::stencil::Stencil;
use cullet_fracture::particles::Particles;
use cullet_geometry::{Mat3, Vec3};
use cullet_model::tolerance::SAFETY;

/// What becomes of pairs of a point and a node on the other side of the open crack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Coupling {
    /// They stay coupled, but across the first crack: one field.
    Whole,
    /// The point gives the node nothing; the node answers with the point's own velocity.
    Compatible,
    /// The same, but the point gives the node its momentum, as in the thesis's (A.4).
    Leaky,
}

/// Tiles of the plane along a spacing.
const FINE: f64 = 8.0;
/// Farthest that a broken point opens the plane, in spacings.
const REACH: f64 = 1.5;
/// Steps between looks at what has broken, as in the solver.
const REFRESH: u64 = 4;

/// For cubes along the grid.
pub(crate) struct Twin {
    pub(crate) particles: Particles,
    pub(crate) grip: Option<PrescribedVelocity>,
    pub(crate) step: f64,
    pub(crate) steps: u64,
    coupling: Coupling,
    specimen: Specimen,
    law: Softening,
    motions: Vec<PointMotion>,
    stencils: Vec<Stencil>,
    /// Nodes and weights of each point.
    around: Vec<[(u32, f64); AROUND]>,
    /// A bit for each of the 27 nodes that is on the other side.
    hidden: Vec<u32>,
    /// Place of the first node, and their number along each axis.
    origin: [i32; 3],
    size: usize,
    mass: Vec<f64>,
    velocity: Vec<Vec3>,
    /// Where the plane is open, x first.
    open: Vec<bool>,
    cut: Vec<bool>,
}

/// The nodes around a point in the dense array, and their weights.
fn around(stencil: &Stencil, origin: &[i32; 3], size: usize) -> [(u32, f64); AROUND] {
    let mut found = [(0, 0.0); AROUND];
    stencil.visit(|k, weight, _| {
        let at = [k / 9, k / 3 % 3, k % 3];
        let [x, y, z] = [0, 1, 2].map(|a| (stencil.cell[a] - origin[a]) as usize + at[a]);
        found[k] = (((x * size + y) * size + z) as u32, weight);
    });
    found
}

impl Twin {
    pub(crate) fn new(specimen: Specimen, way: Vec3, coupling: Option<Coupling>) -> Self {
        let particles = specimen.particles();
        let n = particles.len();
        let half = specimen.half.x;
        let size = (2.0 * half) as usize + 8;
        let low = specimen.middle - Vec3::repeat(half + 4.0);
        let tiles = (2.0 * half * FINE) as usize;
        let launch = specimen.launch(way);
        let rise = Mat3::from_columns(&[Vec3::zeros(), way / (half * H), Vec3::zeros()]);
        let start = |x: &Vec3| PointMotion {
            displacement: Vec3::zeros(),
            displacement_gradient: Mat3::zeros(),
            velocity: launch(x),
            velocity_gradient: rise,
        };
        let origin = [low.x, low.y, low.z].map(|a| a.floor() as i32);
        let stencils: Vec<Stencil> =
            particles.reference.iter().map(|x| Stencil::new(x, &Vec3::repeat(H))).collect();
        let notched = |tile: usize| coupling.is_some() && tile / tiles < tiles / 2;
        let mut twin = Self {
            grip: Some(specimen.grip(way)),
            step: SAFETY * stable_step(&STONE, H),
            steps: 0,
            coupling: coupling.unwrap_or(Coupling::Whole),
            specimen,
            law: Specimen::law(),
            motions: particles.reference.iter().map(start).collect(),
            around: stencils.iter().map(|s| around(s, &origin, size)).collect(),
            stencils,
            hidden: vec![0; n],
            origin,
            size,
            mass: vec![0.0; size * size * size],
            velocity: vec![Vec3::zeros(); size * size * size],
            open: (0..tiles * tiles).map(notched).collect(),
            cut: vec![false; n],
            particles,
        };
        twin.hide();
        twin
    }

    pub(crate) fn motions(&self) -> Vec<PointMotion> {
        self.motions.clone()
    }

    /// Leaves `share` of all velocities \[1\].
    pub(crate) fn damp(&mut self, share: f64) {
        for motion in &mut self.motions {
            motion.velocity *= share;
            motion.velocity_gradient *= share;
        }
    }

    /// Opens the whole plane.
    pub(crate) fn open(&mut self) {
        self.open.fill(true);
        self.hide();
    }

    /// Takes one step; the energy that went into damage \[J\].
    pub(crate) fn advance(&mut self) -> f64 {
        let dissipated = self.scatter();
        self.move_nodes();
        self.gather();
        self.steps += 1;
        let grows = self.coupling != Coupling::Whole && self.steps.is_multiple_of(REFRESH);
        if grows && self.tear() {
            self.hide();
        }
        dissipated
    }

    fn scatter(&mut self) -> f64 {
        self.mass.fill(0.0);
        self.velocity.fill(Vec3::zeros());
        let mut dissipated = 0.0;
        for p in 0..self.particles.len() {
            let (motion, mass) = (self.motions[p], self.particles.mass(p));
            let volume = self.particles.volume[p];
            let (stress, lost) = self.stress(p, &motion.displacement_gradient);
            dissipated += lost * volume;
            let push = stress * (self.step * volume * 4.0 / (H * H));
            let affine = (motion.velocity_gradient * mass - push) * H;
            let (momentum, away) = (motion.velocity * mass, self.stencils[p].away);
            for (k, &(node, weight)) in self.around[p].iter().enumerate() {
                let node = node as usize;
                if self.hidden[p] & (1 << k) == 0 {
                    let apart = Vec3::new(away[0][k / 9], away[1][k / 3 % 3], away[2][k % 3]);
                    self.velocity[node] += (momentum + affine * apart) * weight;
                } else if self.coupling == Coupling::Leaky {
                    self.velocity[node] += momentum * weight;
                } else {
                    continue;
                }
                self.mass[node] += mass * weight;
            }
        }
        dissipated
    }

    /// First Piola–Kirchhoff stress \[Pa\] after damage, and what that took \[J/m³\].
    fn stress(&mut self, p: usize, h: &Mat3) -> (Mat3, f64) {
        let (damage, strength) = (self.particles.damage[p], self.particles.strength[p]);
        let state = DamageState { damage, strength, shielded: false, lone: 1.0 };
        let response = self.law.respond(&green_strain(h), state);
        self.particles.damage[p] = response.damage;
        ((Mat3::identity() + h) * matrix(&response.stress), response.dissipated)
    }

    fn move_nodes(&mut self) {
        for n in 0..self.mass.len() {
            if self.mass[n] <= 0.0 {
                continue;
            }
            self.velocity[n] /= self.mass[n];
            let at = [n / (self.size * self.size), n / self.size % self.size, n % self.size];
            let place = |a: usize| f64::from(self.origin[a] + at[a] as i32) * H;
            let held =
                self.grip.as_ref().and_then(|g| g.0(Vec3::new(place(0), place(1), place(2))));
            self.velocity[n] = held.unwrap_or(self.velocity[n]);
        }
    }

    fn gather(&mut self) {
        for p in 0..self.particles.len() {
            let (away, own) = (self.stencils[p].away, self.motions[p].velocity);
            let (mut velocity, mut gradient) = (Vec3::zeros(), Mat3::zeros());
            for (k, &(node, weight)) in self.around[p].iter().enumerate() {
                let seen = self.hidden[p] & (1 << k) == 0;
                let v = if seen { self.velocity[node as usize] } else { own } * weight;
                let apart = Vec3::new(away[0][k / 9], away[1][k / 3 % 3], away[2][k % 3]);
                velocity += v;
                gradient += v * apart.transpose();
            }
            gradient *= 4.0 / H;
            let motion = &mut self.motions[p];
            motion.velocity = velocity;
            motion.velocity_gradient = gradient;
            motion.displacement += velocity * self.step;
            motion.displacement_gradient += gradient * self.step;
        }
    }

    /// The tile of the plane at x and z, in spacings.
    fn tile(&self, x: f64, z: f64) -> Option<usize> {
        let tiles = (2.0 * self.specimen.half.x * FINE) as usize;
        let place = |a: f64| (a + self.specimen.half.x) * FINE;
        let within = |a: f64| (0.0..tiles as f64).contains(&place(a));
        (within(x) && within(z)).then(|| place(x) as usize * tiles + place(z) as usize)
    }

    /// Opens the plane around points that broke; whether there were any.
    fn tear(&mut self) -> bool {
        let mut torn = false;
        let side = (0.5 * FINE) as i32;
        for p in 0..self.particles.len() {
            let x = self.specimen.local(&self.particles.reference[p]);
            if self.cut[p] || self.particles.damage[p] < 1.0 || x.y.abs() > REACH {
                continue;
            }
            (self.cut[p], torn) = (true, true);
            for (i, k) in (-side..=side).flat_map(|i| (-side..=side).map(move |k| (i, k))) {
                let away = (f64::from(i) / FINE, f64::from(k) / FINE);
                if away.0 * away.0 + away.1 * away.1 <= 0.25
                    && let Some(tile) = self.tile(x.x + away.0, x.z + away.1)
                {
                    self.open[tile] = true;
                }
            }
        }
        torn
    }

    /// Finds the nodes that each point sees through the open crack.
    fn hide(&mut self) {
        for p in 0..self.particles.len() {
            let reference = self.particles.reference[p];
            let x = self.specimen.local(&reference);
            let mut hidden = 0;
            self.stencils[p].visit(|k, _, away| {
                let node = self.specimen.local(&(reference + away * H));
                if x.y * node.y < 0.0 {
                    let at = x + (node - x) * (x.y / (x.y - node.y));
                    if self.tile(at.x, at.z).is_some_and(|tile| self.open[tile]) {
                        hidden |= 1 << k;
                    }
                }
            });
            self.hidden[p] = hidden;
        }
    }
}
