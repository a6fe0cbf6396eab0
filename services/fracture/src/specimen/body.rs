//! A specimen as material points on a grid: its steps, with what supports and loads do in them.

use super::build;
use super::hold::{self, Mirror, SupportNodes};
use super::push::{self, Pushed};
use super::read;
use crate::mpm::Domain;
use crate::mpm::contact::Shove;
use crate::mpm::stencil::{packed, vector};
use cullet_geometry::Vec3;
use cullet_model::Refusal;
use cullet_specimen::{
    BodySums, Discrete, Discretisation, Drive, GridFrame, Hold, PointField, PointFields,
    SpecimenProblem, StepTally, idle,
};

/// A specimen on its grid.
#[derive(Debug)]
struct GridSpecimen {
    domain: Domain,
    frame: GridFrame,
    holds: Vec<Hold>,
    held: Vec<SupportNodes>,
    mirrors: Vec<Mirror>,
    pushed: Vec<Pushed>,
    /// The velocity that held nodes shall have, by node.
    wanted: Vec<Vec3>,
    /// Nodes that a load may push, and their velocity before the step.
    pushed_nodes: Vec<u32>,
    before: Vec<Vec3>,
}

/// Puts a specimen on its grid.
///
/// # Errors
/// The bound that the specimen breaks.
pub(super) fn discrete(specimen: &SpecimenProblem) -> Result<Discrete, Refusal> {
    build::check(specimen)?;
    let domain = build::domain(specimen)?;
    let frame = GridFrame::new(&specimen.body);
    let held = hold::held(specimen, &frame, &domain.grid);
    let mirrors = hold::mirrors(specimen, &frame, &domain.grid)?;
    let pushed = push::pushed(specimen, &frame, &domain);
    idle("support", held.iter().map(|held| held.nodes.is_empty()))?;
    let loads = specimen.loads.iter().zip(&pushed);
    idle("load", loads.map(|(load, on)| on.nodes.is_empty() && !load.push.is_none()))?;
    let mut body = GridSpecimen {
        domain,
        frame,
        holds: specimen.holds.clone(),
        held,
        mirrors,
        pushed,
        wanted: Vec::new(),
        pushed_nodes: Vec::new(),
        before: Vec::new(),
    };
    body.note_pushed();
    Ok(Discrete {
        points: body.domain.particles.len() as u64,
        stable_step: build::step(specimen),
        strength_ratio: build::strength_ratio(specimen),
        frame,
        loads: body.pushed.iter().map(|pushed| pushed.total).collect(),
        body: Box::new(body),
    })
}

impl Discretisation for GridSpecimen {
    fn step(&mut self, drive: &Drive<'_>) -> StepTally {
        self.domain.step = drive.step;
        let damped = self.damp(drive);
        let velocity = |domain: &Domain, n: u32| vector(domain.grid.nodes.velocity[n as usize]);
        self.before =
            (0..self.domain.grid.nodes.len() as u32).map(|n| velocity(&self.domain, n)).collect();
        let mut forces = self.push(drive);
        let nodes = self.domain.grid.nodes.len();
        let tally = self.domain.advance();
        let dissipated = tally.dissipated + tally.plastic;
        if self.domain.grid.nodes.len() != nodes {
            let origins = &self.domain.grid.nodes.origin[nodes..];
            let more: Vec<Vec3> = origins.iter().map(|&n| self.before[n as usize]).collect();
            self.before.extend(more);
            self.follow(nodes as u32);
            // What a node took its copies now carry; its own share is all that is accounted for.
            forces.retain(|(n, _)| self.pushed_nodes.binary_search(n).is_ok());
        }
        let (held, reactions) = self.hold(drive);
        self.mirrors.iter().for_each(|mirror| mirror.apply(&mut self.domain.grid, drive.step));
        let met = self.met();
        let pushed: f64 = forces
            .iter()
            .map(|(n, f)| {
                let mean = (self.before[*n as usize] + velocity(&self.domain, *n)) / 2.0;
                f.dot(&mean) * drive.step
            })
            .sum();
        StepTally { dissipated, damped, met, pushed, held, reactions, limit: None }
    }

    fn sums(&self) -> BodySums {
        BodySums {
            kinetic: self.domain.kinetic_energy(),
            elastic: self.domain.elastic_energy(),
            momentum: self.domain.momentum(),
            angular_momentum: self.domain.angular_momentum(),
            finite: self.domain.is_finite(),
        }
    }

    fn points(&self, fields: &[PointField]) -> PointFields {
        read::points(&self.domain, fields)
    }

    fn pieces(&self) -> Vec<f64> {
        read::shares(&self.domain)
    }
}

impl GridSpecimen {
    /// Hands supports, loads and planes of symmetry on to the nodes from `first` on, which a crack
    /// has just made of others.
    fn follow(&mut self, first: u32) {
        let nodes = &self.domain.grid.nodes;
        self.held.iter_mut().for_each(|held| held.follow(nodes, first));
        self.mirrors.iter_mut().for_each(|mirror| mirror.follow(nodes, first));
        let groups = push::groups(nodes, first);
        self.pushed.iter_mut().for_each(|pushed| pushed.follow(nodes, &groups));
        self.note_pushed();
    }

    fn note_pushed(&mut self) {
        let all = self.pushed.iter().flat_map(|pushed| pushed.nodes.iter().map(|node| node.0));
        self.pushed_nodes = all.collect();
        self.pushed_nodes.sort_unstable();
        self.pushed_nodes.dedup();
    }

    /// Slows all nodes down; the energy that this took \[J\].
    fn damp(&mut self, drive: &Drive<'_>) -> f64 {
        if drive.damping <= 0.0 {
            return 0.0;
        }
        let half = 0.5 * drive.damping * drive.step;
        let share = (1.0 - half) / (1.0 + half);
        let kinetic = self.domain.kinetic_energy();
        for v in &mut self.domain.grid.nodes.velocity {
            *v *= wide::f64x4::splat(share);
        }
        kinetic * (1.0 - share * share)
    }

    /// Applies the loads for one step; the force on each node \[N\].
    fn push(&mut self, drive: &Drive<'_>) -> Vec<(u32, Vec3)> {
        let mut forces: Vec<(u32, Vec3)> =
            self.pushed_nodes.iter().map(|&n| (n, Vec3::zeros())).collect();
        for (pushed, &factor) in self.pushed.iter().zip(drive.loads) {
            if factor != 0.0 {
                for (node, force) in &pushed.nodes {
                    if let Ok(at) = forces.binary_search_by_key(node, |row| row.0) {
                        forces[at].1 += force * factor;
                    }
                }
            }
        }
        let nodes = &mut self.domain.grid.nodes;
        for (node, force) in &forces {
            let n = *node as usize;
            nodes.velocity[n] += packed(force * (drive.step / nodes.mass[n]));
        }
        forces
    }

    /// Energy that went where sides met in this step: what their pushes did on the way of both
    /// \[J\].
    fn met(&self) -> f64 {
        let velocities = &self.domain.grid.nodes.velocity;
        let way = |n: u32| self.before[n as usize] + vector(velocities[n as usize]);
        let gain = |shove: &Shove| {
            let [first, second] = shove.nodes;
            0.5 * shove.impulse.dot(&(way(second) - way(first)))
        };
        -self.domain.shoves().iter().map(gain).sum::<f64>()
    }

    /// Gives held nodes their velocities; the work that this took \[J\], and the force of each
    /// support \[N\].
    ///
    /// The first of several supports that hold a node along an axis has the whole force.
    fn hold(&mut self, drive: &Drive<'_>) -> (f64, Vec<Vec3>) {
        let mut work = 0.0;
        let mut reactions = vec![Vec3::zeros(); self.held.len()];
        self.wanted.resize(self.domain.grid.nodes.len(), Vec3::zeros());
        hold::add_up(&self.held, &self.holds, drive.holds, &mut self.wanted);
        let rows = self.held.iter().zip(&self.holds).zip(drive.holds).zip(&mut reactions);
        for (((held, hold), _), reaction) in rows.filter(|((_, factor), _)| factor.is_some()) {
            let mut sum = Vec3::zeros();
            for &(node, _) in &held.nodes {
                let n = node as usize;
                let free = vector(self.domain.grid.nodes.velocity[n]);
                let mut local = self.frame.unturned(&free);
                for axis in (0..3).filter(|&a| hold.axes[a]) {
                    local[axis] = self.wanted[n][axis];
                }
                let now = self.frame.turned(&local);
                let push = (now - free) * self.domain.grid.nodes.mass[n];
                work += push.dot(&(self.before[n] + now)) / 2.0;
                sum += push;
                hold::set(&mut self.domain.grid, node, &now, drive.step);
            }
            *reaction = sum / drive.step;
        }
        (work, reactions)
    }
}
