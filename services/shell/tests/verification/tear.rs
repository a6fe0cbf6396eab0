//! S16: a trouser tear. The legs of a slit sheet are pulled apart, one up and one down, until the
//! sheet tears between them.

use cullet_geometry::Vec3;
use cullet_geometry::nurbs::NurbsPatch;
use cullet_model::Material;
use cullet_shell::domain::{ShellDomain, ShellMaterial};
use cullet_shell::midsurface::Midsurface;
use cullet_shell::section::SectionLaw;
use cullet_simd::SimdLevel;
use rayon::prelude::*;

/// Cells of a sheet, with the slit in the middle row, and of the slit.
const CELLS: [usize; 2] = [100, 61];
const SLIT: usize = 30;

/// Cells that a sheet is torn before the tear is measured.
const LEAD: f64 = 5.0;

/// Cells a second that a leg is pulled.
const PACE: f64 = 700.0;

/// A sheet and how it is pulled.
#[derive(Clone, Copy)]
struct Trouser {
    cell: f64,
    thickness: f64,
    young: f64,
    strength: f64,
    toughness: f64,
    /// Strain of a torn cell that bears nothing any more.
    most_strain: f64,
    /// How far each leg is pulled, in cells: as far as the slit is long until they are upright.
    pull: f64,
}

/// What came of a tear.
#[derive(Debug)]
struct Torn {
    /// In cells, from where it is measured.
    length: f64,
    /// What cracks took over G_f t times the length.
    cost: f64,
    /// Mean force of a leg over G_f t/2.
    force: f64,
    /// What is stored and what cracks took over the work of the grips.
    ledger: f64,
}

type Shell = ShellDomain<f64, 9>;

impl Trouser {
    fn size(&self) -> [f64; 2] {
        CELLS.map(|n| n as f64 * self.cell)
    }

    fn tip(&self) -> f64 {
        SLIT as f64 * self.cell - 0.5 * self.size()[0]
    }

    /// The sheet with its slit; only what is ahead of it can tear.
    fn shell(&self) -> Shell {
        let patch = NurbsPatch::sheet(self.size(), CELLS, 2).unwrap();
        let surface = Midsurface::of_patch(&patch);
        let places: Vec<Vec3> =
            (0..surface.points()).map(|p| surface.surface_point(p).place).collect();
        let tip = self.tip();
        let stuff = Material {
            density: 1000.0,
            young: self.young,
            poisson: 0.3,
            failure_stress: self.strength,
            fracture_energy: self.toughness,
        };
        let strength = |x: &Vec3| match x.x > tip - 4.0 * self.cell {
            true => self.strength,
            false => f64::INFINITY,
        };
        let material = ShellMaterial {
            law: SectionLaw { most_strain: self.most_strain, ..SectionLaw::new(&stuff) },
            density: stuff.density,
            thickness: vec![self.thickness; places.len()],
            strength: places.iter().map(strength).collect(),
            softening_cells: 1.1,
        };
        let mut shell = Shell::new(surface, material, SimdLevel::best());
        for (point, at) in places.iter().enumerate() {
            if at.x < tip && at.y.abs() < 0.5 * self.cell {
                shell.notch(point, [0.0, 1.0]);
            }
        }
        shell.wake_tips();
        shell
    }

    fn tear(&self) -> Torn {
        let mut shell = self.shell();
        // Legs that are stretched and thrown about are stiffer than the sheet at rest.
        shell.step *= 0.6;
        let (nodes, speed) = (shell.surface.nodes.clone(), PACE * self.cell);
        let end = 1.1 * self.cell - 0.5 * self.size()[0];
        // Which way a control point is pulled: the ends of the legs, up and down.
        let way = |node: usize| match nodes.get(node) {
            Some(at) if at.x < end && at.y.abs() > 2.0 * self.cell => at.y.signum(),
            _ => 0.0,
        };
        let grips: Vec<usize> = (0..nodes.len()).filter(|&n| way(n) != 0.0).collect();
        let places: Vec<f64> =
            (0..shell.points()).map(|p| shell.surface.surface_point(p).place.x).collect();
        let torn = |shell: &Shell| {
            let broken = (0..places.len()).filter(|&p| shell.state(p).is_broken());
            broken.map(|p| places[p]).fold(self.tip(), f64::max) - self.tip()
        };
        let (mut work, mut taken, mut force, mut steps) = (0.0, 0.0, 0.0, 0.0);
        let mut from = None;
        for step in 0..(self.pull * self.cell / speed / shell.step) as usize {
            let speed = speed * (step as f64 / 500.0).min(1.0);
            let tally = shell.advance(|node, v| match way(node) {
                0.0 => v,
                way => Vec3::new(0.0, 0.0, way * speed),
            });
            taken += tally.points.dissipated + tally.met;
            let both: f64 = grips.iter().map(|&n| -shell.force(n).z * way(n)).sum();
            work += both * speed * shell.step;
            if from.is_some() {
                (force, steps) = (force + both, steps + 1.0);
            } else if step % 100 == 0 {
                let length = torn(&shell);
                from = (length > LEAD * self.cell).then_some((length, taken));
            }
        }
        let (start, before) = from.expect("the sheet tears");
        let (length, sums) = (torn(&shell) - start, shell.sums());
        let toughness = self.toughness * self.thickness;
        Torn {
            length: length / self.cell,
            cost: (taken - before) / (toughness * length),
            force: force / steps / toughness,
            ledger: (sums.kinetic + sums.elastic + taken) / work,
        }
    }
}

/// Legs that do not stretch pull with F = G_f t/2. The closer cells are to the opening w_c =
/// 2G_f/σ_f at which a crack lets go, the more they pull, and what they pull more goes into waves;
/// a film's tear itself costs what the toughness says. A stiff sheet's costs more: cells beside the
/// tear are torn with it before their control points part.
#[test]
fn s16_a_trouser_tear_costs_its_energy() {
    let film = Trouser {
        cell: 0.5e-3,
        thickness: 0.05e-3,
        young: 2.5e6,
        strength: 2.5e6,
        toughness: 8e3,
        most_strain: 20.0,
        pull: 85.0,
    };
    let coarse = Trouser { toughness: 1e3, pull: 60.0, ..film };
    let stiff = Trouser {
        young: 50e6,
        strength: 4e6,
        toughness: 500.0,
        thickness: 0.125e-3,
        most_strain: 2.0,
        pull: 50.0,
        ..film
    };
    let sheets = [("film, w_c 13 cells", film), ("film, w_c 1.6 cells", coarse), ("stiff", stiff)];
    let found: Vec<Torn> = sheets.par_iter().map(|(_, sheet)| sheet.tear()).collect();
    for ((what, _), torn) in sheets.iter().zip(&found) {
        println!("S16, {what}: {torn:?}");
        assert!(torn.length > 8.0, "{what}: {torn:?}");
    }
    let [film, coarse, stiff] = &found[..] else { unreachable!("three sheets") };
    assert!(found[..2].iter().all(|torn| (torn.ledger - 1.0).abs() < 0.01), "{found:?}");
    assert!((film.cost - 1.0).abs() < 0.15 && (0.95..1.25).contains(&film.force), "{film:?}");
    assert!((coarse.cost - 1.0).abs() < 0.1 && (0.95..1.8).contains(&coarse.force), "{coarse:?}");
    // It gains energy, where cells are torn twice over.
    assert!((2.0..4.0).contains(&stiff.cost) && (0.95..1.1).contains(&stiff.ledger), "{stiff:?}");
}
