//! What a contact that crushes does to the body under it, on a grid that is too coarse to see it.
//!
//! Crushed rubble goes on to carry the load, held by what is around it, so the points under the
//! contact do not break. A crack starts from it: the half-pennies that contact mechanics say stand
//! there, c = (χF/K_Ic)^{2/3} with χ = 0.016 √(E/H) \[Lawn, Evans and Marshall 1980; Anstis and
//! others 1981, from memory\]; from there on the solver's law decides. And the crushed zone, which
//! takes more room than before, pushes apart what is around it, as far as the volume that was
//! pressed into it lasts. The work of both is part of what crushing takes.

use crate::mpm::Domain;
use crate::mpm::load::ImpactLoad;
use crate::mpm::load_patch::SpreadPatch;
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_model::BrittleProblem;
use std::f64::consts::{PI, TAU};

/// χ over √(E/H) \[1\].
const INDENTATION: f64 = 0.016;

/// Push of the crushed zone across a half-plane through the contact's axis over χF \[1\]: in
/// plaster, χ = 0.19, that is 0.16 F, as of a cone of rubble that wedges at an angle of 63°.
const WEDGE: f64 = 0.85;

/// How far the zone pushes outward over a²/R, the depth of the cap that was pressed in \[1\].
const SPREAD: f64 = 0.03;

/// Half-planes through the axis in which cracks start: what comes of them does not depend on how
/// many there are.
const CRACKS: u32 = 3;

/// Longest starting crack over the reach of the body from its middle \[1\]: beyond, it is no
/// half-space.
const LONGEST: f64 = 0.5;

/// Cells by which a starting crack grows at once, and within which of it points are at a crack.
const GROWTH: f64 = 0.5;
const BESIDE: f64 = 0.6;

/// Strength of a point that carries on when it is crushed, over the law's.
const HELD: f64 = 1e12;

/// Stream of the seed's numbers.
const STREAM: u64 = 0x57a7;

/// A contact in which the body itself crushes.
#[derive(Clone, Debug)]
pub(super) struct CrushedZone {
    spread: SpreadPatch,
    /// χ \[1\].
    indentation: f64,
    /// K_Ic \[Pa √m\] and G_f \[J/m²\].
    toughness: f64,
    fracture_energy: f64,
    /// Unit vectors from the axis along each half-plane.
    ways: Vec<Vec3>,
    /// Radius of the starting cracks so far, and the longest they may have \[m\].
    pub(super) length: f64,
    longest: f64,
    /// Work of the zone on the body so far \[J\].
    pub(super) work: f64,
    /// Outward impulse of the last step \[N·s\], and the speed before it \[m/s\].
    last: (f64, f64),
}

impl CrushedZone {
    /// The zone under a load that crushes the body, whose points carry on; none where it does not,
    /// and none on a plate of flat cells: that is no half-space, and is pierced.
    pub(super) fn under(
        load: &ImpactLoad,
        index: usize,
        problem: &BrittleProblem,
        domain: &mut Domain,
    ) -> Option<Self> {
        let impact = &problem.impacts[index];
        let own = problem.surface.hardness <= impact.crushing_pressure * (1.0 + 1e-9);
        let flat = domain.grid.spacing.min() < domain.grid.spacing.max();
        if flat || !own || !load.will_crush(impact.energy) {
            return None;
        }
        for &(id, _) in load.patch.shares() {
            let slot = domain.slot(id);
            domain.particles.strength[slot] = HELD;
        }
        let (material, axis) = (&problem.material, load.direction);
        let across = axis.cross(&axis.yzx()).try_normalize(1e-3);
        let across = across.or_else(|| axis.cross(&Vec3::x()).try_normalize(1e-3))?;
        let turn = unit(problem.seed, STREAM, index as u64);
        let way = |k| {
            let (sin, cos) = libm::sincos(TAU * (f64::from(k) + turn) / f64::from(CRACKS));
            across * cos + axis.cross(&across) * sin
        };
        let reach = domain.particles.reference.iter().map(Vec3::norm).fold(0.0, f64::max);
        Some(Self {
            spread: SpreadPatch::new(&load.patch, domain, &load.point, &axis),
            indentation: INDENTATION * (material.young / problem.surface.hardness).sqrt(),
            toughness: (material.young * material.fracture_energy).sqrt(),
            fracture_energy: material.fracture_energy,
            ways: (0..CRACKS).map(way).collect(),
            length: 0.0,
            longest: LONGEST * reach,
            work: 0.0,
            last: (0.0, 0.0),
        })
    }

    /// Energy of the starting cracks: three quarters of discs \[J\].
    pub(super) fn starting_energy(&self) -> f64 {
        self.energy_of(self.length)
    }

    fn energy_of(&self, length: f64) -> f64 {
        0.25 * f64::from(CRACKS) * PI * length * length * self.fracture_energy
    }

    /// Pushes outward and starts cracks by the force of the load in the next step.
    pub(super) fn push(&mut self, load: &ImpactLoad, domain: &mut Domain) {
        self.last = (0.0, 0.0);
        let crushed = load.crushing_energy();
        if crushed <= 0.0 || load.is_over() {
            return;
        }
        let length = libm::cbrt(self.indentation * load.force / self.toughness);
        let length = (length * length).min(self.longest);
        let spacing = domain.grid.spacing.max();
        let more = length >= spacing && length >= self.length + GROWTH * spacing;
        if more && self.energy_of(length) + self.work <= crushed {
            self.crack(load, length, domain);
        }
        let (moved, speed) = self.spread.motion(domain);
        let most = SPREAD * load.depth_of_cap();
        let share = if moved < most { 1.0 - moved.max(0.0) / most } else { 0.0 };
        if self.starting_energy() + self.work < crushed {
            let impulse = PI * WEDGE * self.indentation * load.force * share * domain.step;
            self.spread.push(domain, impulse);
            self.last = (impulse, speed);
        }
    }

    /// Books the work of the step that was just taken, as a striker's is.
    pub(super) fn book(&mut self, domain: &Domain) {
        let (impulse, before) = self.last;
        if impulse > 0.0 {
            self.work += 0.5 * impulse * (before + self.spread.motion(domain).1);
        }
    }

    fn crack(&mut self, load: &ImpactLoad, length: f64, domain: &mut Domain) {
        let (point, axis) = (load.point, load.direction);
        let sheets: Vec<(Vec3, Vec3)> =
            self.ways.iter().map(|way| (*way, axis.cross(way))).collect();
        let within = |x: &Vec3, way: &Vec3| x.dot(way) > 0.0 && x.norm() <= length;
        domain.crack(&point, length, |a, b| {
            sheets.iter().any(|(way, normal)| {
                let (a, b) = (a - point, b - point);
                let (below, above) = (a.dot(normal), b.dot(normal));
                below < 0.0
                    && above >= 0.0
                    && within(&(a + (b - a) * (below / (below - above))), way)
            })
        });
        let beside = BESIDE * domain.grid.spacing.max();
        let near = |x: &Vec3| {
            let x = x - point;
            sheets.iter().any(|(way, normal)| x.dot(normal).abs() < beside && within(&x, way))
        };
        let particles = &domain.particles;
        let ids = particles.reference.iter().zip(&particles.id).filter(|(x, _)| near(x));
        let ids: Vec<u32> = ids.map(|(_, &id)| id).collect();
        let time = domain.time;
        ids.into_iter().for_each(|id| domain.open(id, time));
        self.length = length;
    }
}
