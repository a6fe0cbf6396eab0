//! Loads: what part of them each node takes.

use crate::mpm::Domain;
use crate::mpm::grid::{BackgroundGrid, Nodes};
use crate::mpm::stencil::Stencil;
use cullet_geometry::Vec3;
use cullet_specimen::surface::pieces;
use cullet_specimen::{GridFrame, Load, LoadKind, SpecimenProblem, within};

/// A load at 1 of its course, by node, in the grid's frame \[N\].
#[derive(Clone, Debug, Default)]
pub(super) struct Pushed {
    pub(super) nodes: Vec<(u32, Vec3)>,
    /// Their sum \[N\].
    pub(super) total: Vec3,
}

/// Each node that the nodes from `first` on were made of, with all that were made of it.
pub(super) fn groups(nodes: &Nodes, first: u32) -> Vec<Vec<u32>> {
    let origin = |n: u32| nodes.origin[n as usize];
    let mut origins: Vec<u32> = (first..nodes.len() as u32).map(origin).collect();
    origins.sort_unstable();
    origins.dedup();
    let mut groups: Vec<Vec<u32>> = origins.iter().map(|&n| vec![n]).collect();
    for n in (0..nodes.len() as u32).filter(|&n| origin(n) != n) {
        if let Ok(at) = origins.binary_search(&origin(n)) {
            groups[at].push(n);
        }
    }
    groups
}

impl Pushed {
    /// Shares out the force of each group anew, by mass.
    pub(super) fn follow(&mut self, nodes: &Nodes, groups: &[Vec<u32>]) {
        for group in groups {
            let own = |n: &u32| self.nodes.binary_search_by_key(n, |row| row.0).ok();
            let sum: Vec3 = group.iter().filter_map(own).map(|at| self.nodes[at].1).sum();
            if sum.norm_squared() == 0.0 {
                continue;
            }
            let mass: f64 = group.iter().map(|&n| nodes.mass[n as usize]).sum();
            self.nodes.retain(|row| !group.contains(&row.0));
            let share = |&n: &u32| (n, sum * (nodes.mass[n as usize] / mass));
            self.nodes.extend(group.iter().map(share));
            self.nodes.sort_unstable_by_key(|row| row.0);
        }
    }
}

/// The nodes of each load.
pub(super) fn pushed(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    domain: &Domain,
) -> Vec<Pushed> {
    let surface = || pieces(&specimen.body.mesh, specimen.settings.spacing);
    let surface = specimen.loads.iter().any(is_surface).then(surface);
    let order = by_place(&domain.grid);
    let one = |load: &Load| {
        let mut forces = vec![Vec3::zeros(); domain.grid.nodes.len()];
        match load.push {
            LoadKind::Traction(_) | LoadKind::Pressure(_) => {
                for piece in surface.iter().flatten().filter_map(|piece| piece.within(&load.part)) {
                    let force = frame.turned(&piece.force(&load.push));
                    spread(&domain.grid, &order, &frame.onto(&piece.middle), force, &mut forces);
                }
            }
            LoadKind::Force(_) | LoadKind::Acceleration(_) => {
                on_mass(load, frame, domain, &mut forces);
            }
        }
        let total = forces.iter().sum();
        let nodes = (0_u32..).zip(forces).filter(|(_, force)| force.norm_squared() > 0.0);
        Pushed { nodes: nodes.collect(), total }
    };
    specimen.loads.iter().map(one).collect()
}

fn is_surface(load: &Load) -> bool {
    matches!(load.push, LoadKind::Traction(_) | LoadKind::Pressure(_))
}

/// Nodes by place, copies beside each other.
fn by_place(grid: &BackgroundGrid) -> Vec<([i32; 3], u32)> {
    let mut order: Vec<([i32; 3], u32)> =
        grid.nodes.place.iter().enumerate().map(|(n, &place)| (place, n as u32)).collect();
    order.sort_unstable();
    order
}

/// Spreads a force at a place over the nodes around it by weight and mass: light nodes, which the
/// surface has many of, are moved no more than others.
fn spread(
    grid: &BackgroundGrid,
    order: &[([i32; 3], u32)],
    at: &Vec3,
    force: Vec3,
    forces: &mut [Vec3],
) {
    let stencil = Stencil::new(at, &grid.spacing);
    let mut shares: Vec<(u32, f64)> = Vec::with_capacity(27);
    stencil.visit(|k, weight, _| {
        let [i, j, l] = [k / 9, k / 3 % 3, k % 3].map(|n| n as i32);
        let [x, y, z] = stencil.cell;
        let place = [x + i, y + j, z + l];
        let first = order.partition_point(|row| row.0 < place);
        for &(_, node) in order[first..].iter().take_while(|row| row.0 == place) {
            shares.push((node, weight * grid.nodes.mass[node as usize]));
        }
    });
    let sum: f64 = shares.iter().map(|share| share.1).sum();
    if sum > 0.0 {
        shares.iter().for_each(|&(n, share)| forces[n as usize] += force * (share / sum));
    }
}

fn on_mass(load: &Load, frame: &GridFrame, domain: &Domain, forces: &mut [Vec3]) {
    let particles = &domain.particles;
    let taken: Vec<bool> =
        particles.reference.iter().map(|x| within(&load.part, &frame.back(x), 0.0)).collect();
    let mass: f64 = (0..taken.len()).filter(|&p| taken[p]).map(|p| particles.mass(p)).sum();
    let rate = match load.push {
        LoadKind::Acceleration(acceleration) => acceleration,
        LoadKind::Force(force) if mass > 0.0 => force / mass,
        _ => Vec3::zeros(),
    };
    let rate = frame.turned(&rate);
    for element in &domain.grid.elements {
        for p in element.points().filter(|&p| taken[p]) {
            let stencil = Stencil::new(&particles.reference[p], &domain.grid.spacing);
            stencil.visit(|k, weight, _| {
                forces[element.nodes[k] as usize] += rate * (weight * particles.mass(p));
            });
        }
    }
}
