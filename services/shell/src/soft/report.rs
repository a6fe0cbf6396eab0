//! What a window reports: its ledger, pieces, figures and warnings.

use super::run::SoftShellRun;
use super::state::RetiredShare;
use super::window::WallWindow;
use crate::domain::TIP_FACTOR;
use cullet_continuum::pieces::torn_pieces;
use cullet_geometry::Vec3;
use cullet_model::outcome::STRENGTH_RATIO;
use cullet_model::{Failure, Figure, MembranePace, SweptExtent, TornPiece, WindowLedger};

/// Momentum closes to this share of what was exchanged.
const CLOSED: f64 = 1e-9;
/// Energy that is there and should not be, over what there is, above which a warning is given.
const ENERGY_SLACK: f64 = 0.02;
/// Kinetic over elastic energy of a heavier shell above which a warning is given.
const MOST_KINETIC: f64 = 0.05;

impl<const N: usize> SoftShellRun<N> {
    /// Momentum \[kg·m/s\].
    pub(super) fn momentum(&self) -> Vec3 {
        let domain = &self.state.domain;
        domain.mass.iter().zip(&domain.velocity).map(|(m, v)| v * *m).sum()
    }

    fn angular_momentum(&self) -> Vec3 {
        let domain = &self.state.domain;
        let (_, places) = domain.node_places();
        let moving = domain.mass.iter().zip(&domain.velocity);
        places.iter().zip(moving).map(|(x, (m, v))| x.cross(v) * *m).sum()
    }
}

impl<const N: usize> WallWindow<N> {
    pub(super) fn ledger(&mut self) -> WindowLedger {
        let [stretching, bending] = self.run.energies();
        let run = &self.run;
        let books = &run.books;
        let kinetic = run.kinetic();
        let own = run.momentum();
        let grew = kinetic + stretching + bending - self.start.kinetic - self.start.stored;
        let spent = books.broken + books.plastic + books.damped;
        let given = books.air + books.grips + books.gravity + books.bodies;
        WindowLedger {
            mass: run.state.mass() / run.prepared.pace.inertia,
            momentum: own.into(),
            angular_momentum: run.angular_momentum().into(),
            momentum_residual: (books.impulse - (own - self.start.momentum)).into(),
            kinetic,
            stretching,
            bending,
            broken: books.broken,
            plastic: books.plastic,
            damped: books.damped,
            air: books.air,
            grips: books.grips,
            gravity: books.gravity,
            bodies: books.bodies,
            residual: grew + spent - given,
            torn_area: run.state.domain.torn_area(),
            ..WindowLedger::default()
        }
    }

    /// That momentum is accounted for.
    pub(super) fn unbalanced(&self, ledger: &WindowLedger) -> Option<Failure> {
        let domain = &self.run.state.domain;
        let moving: f64 = domain.mass.iter().zip(&domain.velocity).map(|(m, v)| m * v.norm()).sum();
        let scale = self.run.books.exchanged + moving;
        let lost = Vec3::from(ledger.momentum_residual).norm();
        let what = format!("momentum is off by {lost:.3e} of {scale:.3e} kg·m/s exchanged");
        let step = self.run.state.step;
        (lost > CLOSED * scale).then_some(Failure::Beyond { what, step })
    }

    pub(super) fn pieces(&self) -> Vec<TornPiece> {
        let (state, prepared) = (&self.run.state, &self.run.prepared);
        let of = |p: usize| (0.0, state.domain.state(p).area);
        let world_step = prepared.setup.world_step;
        let mut torn = torn_pieces(&state.labels, &state.pieces, world_step, of);
        // Points weigh what control points do, less what corners of the wall hold between them.
        for (mass, number) in state.domain.mass.iter().zip(state.node_pieces()) {
            let Some(number) = number else { continue };
            if let Ok(slot) = torn.binary_search_by_key(&number, |piece| piece.number) {
                torn[slot].mass += mass / prepared.pace.inertia;
            }
        }
        torn
    }

    pub(super) fn figures(&self) -> Vec<Figure> {
        let (prepared, run) = (&self.run.prepared, &self.run);
        let length = f64::from(self.done) * prepared.setup.world_step;
        let mut figures = vec![
            ("working_wave_speed", "m/s", prepared.pace.speed),
            ("working_inertia", "1", prepared.pace.inertia),
            ("working_young", "Pa", prepared.pace.young),
            ("added_mass", "1", prepared.heavier),
            ("thickness", "m", prepared.thickness),
            ("points", "1", run.state.domain.points() as f64),
            ("control_points", "1", run.state.domain.mass.len() as f64),
            ("splits", "1", run.state.domain.mass.len() as f64 - prepared.rest.len() as f64),
            ("steps", "1", run.books.steps as f64),
            ("step", "s", length / run.books.steps.max(1) as f64),
            ("stable_step", "s", prepared.stable),
            ("stiffest", "1", run.books.stiffest),
        ];
        if prepared.breaks {
            figures.push(("tip_strength", "Pa", self.tip_strength()));
            figures.push((STRENGTH_RATIO, "1", self.tip_strength() / prepared.strength));
        }
        if self.retired != RetiredShare::default() {
            let inertia = prepared.pace.inertia;
            figures.push(("retired_mass", "kg", self.retired.mass / inertia));
            figures.push(("retired_energy", "J", self.retired.energy));
        }
        let named = |(name, unit, value): (&str, &str, f64)| Figure {
            name: name.to_owned(),
            unit: unit.to_owned(),
            value,
        };
        let mut figures: Vec<Figure> = figures.into_iter().map(named).collect();
        for (k, impulse) in run.books.held.iter().enumerate() {
            for (axis, part) in ["x", "y", "z"].iter().zip(impulse.iter()) {
                figures.push(named((&format!("grip_{}_force_{axis}", k + 1), "N", part / length)));
            }
        }
        for (proxy, body) in run.proxies.iter().zip(&self.window.proxies) {
            figures.push(named((&format!("body_{}_depth", body.body), "m", proxy.deepest)));
        }
        figures
    }

    /// Strength ahead of a crack at this spacing \[Pa\].
    fn tip_strength(&self) -> f64 {
        self.run.state.domain.tip_strength(self.run.prepared.body.spacing)
    }

    pub(super) fn warnings(&self, ledger: &WindowLedger) -> Vec<String> {
        let mut warnings = Vec::new();
        let (prepared, books) = (&self.run.prepared, &self.run.books);
        let elastic = ledger.stretching + ledger.bending;
        let works = [ledger.air, ledger.grips, ledger.gravity, ledger.bodies];
        let moved: f64 = works.iter().map(|work| work.abs()).sum();
        let scale = moved + ledger.kinetic + elastic + self.start.kinetic + self.start.stored;
        if ledger.residual.abs() > ENERGY_SLACK * scale {
            warnings.push(format!(
                "energy is off by {:.3e} J of {scale:.3e} J in this window",
                ledger.residual
            ));
        }
        let heavier = matches!(prepared.body.pace, MembranePace::Heavier(_));
        if heavier && ledger.kinetic > MOST_KINETIC * elastic {
            warnings.push(format!(
                "the heavier shell moves with {:.3e} J beside {elastic:.3e} J of strain: more than \
                 a twentieth; take a faster pace or load it more slowly",
                ledger.kinetic
            ));
        }
        let ratio = self.tip_strength() / prepared.strength;
        if prepared.breaks && ratio < 1.0 - 1e-9 {
            warnings.push(format!(
                "cracks go on at {ratio:.2} of the strength, {TIP_FACTOR} √(2EG/1.1 l): at this \
                 spacing they are controlled by toughness alone"
            ));
        }
        if books.crushed {
            warnings.push(format!(
                "points were pressed together until they were {:.0} times as stiff as at rest: \
                 more than steps were made smaller for",
                books.stiffest
            ));
        }
        for (proxy, body) in self.run.proxies.iter().zip(&self.window.proxies) {
            if proxy.deepest > 2.0 * prepared.contact() {
                let (depth, body) = (proxy.deepest, body.body);
                warnings.push(format!("points were {depth:.3e} m inside of body {body}"));
            }
        }
        warnings
    }

    pub(super) fn extent(&self) -> SweptExtent {
        let domain = &self.run.state.domain;
        let (_, places) = domain.node_places();
        // Dust is left where it fell apart. Where nothing is left, it is where it was.
        let moves = domain.moves();
        let none = !moves.contains(&true);
        let here = |(x, moves): (Vec3, bool)| (moves || none).then_some(x);
        let places: Vec<Vec3> = places.into_iter().zip(moves).filter_map(here).collect();
        let bound = |pick: fn(f64, f64) -> f64, from: f64| -> [f64; 3] {
            std::array::from_fn(|k| places.iter().map(|x| x[k]).fold(from, pick))
        };
        SweptExtent {
            low: bound(f64::min, f64::MAX),
            high: bound(f64::max, f64::MIN),
            speed: domain.velocity.iter().map(Vec3::norm).fold(0.0, f64::max),
            spacing: self.run.prepared.body.spacing,
        }
    }
}
