//! The families of solvers that a worker hosts: a line each.

use cullet_fracture::{Brittle, Ductile, specimen};
use cullet_geometric::Geometric;
use cullet_membrane::MembraneWindow;
use cullet_model::{ContinuumEntry, SolverEntry, continuum_entry, entry};
use cullet_peridynamics::{Peridynamics, SoftSolidWindow};
use cullet_shell::{ShellSolver, SoftShellWindow};
use cullet_specimen::SpecimenFamily;

/// Every family.
pub const FAMILIES: &[SolverEntry] = &[
    entry::<Brittle>(),
    entry::<Ductile>(),
    entry::<Peridynamics>(),
    entry::<ShellSolver>(),
    entry::<Geometric>(),
];

/// Every family whose bodies move as they deform.
pub const CONTINUA: &[ContinuumEntry] = &[
    continuum_entry::<MembraneWindow>(),
    continuum_entry::<SoftShellWindow>(),
    continuum_entry::<SoftSolidWindow>(),
];

/// Every family that makes specimens discrete.
pub const SPECIMEN_FAMILIES: &[SpecimenFamily] = &[
    specimen::FAMILY,
    specimen::DUCTILE,
    cullet_shell::specimen::FAMILY,
    cullet_peridynamics::specimen::FAMILY,
    cullet_membrane::specimen::FAMILY,
];

/// The family of that name.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static SolverEntry> {
    FAMILIES.iter().find(|family| family.name == name)
}

/// Names of the families that a worker of this program solves, those of moving bodies last.
#[must_use]
pub fn solvers() -> Vec<&'static str> {
    let hit = FAMILIES.iter().map(|entry| entry.name);
    hit.chain(CONTINUA.iter().map(|entry| entry.name)).collect()
}
