//! Windows of a sheet's time, and what came of them.

use super::messages::ReportFigure;
use super::schema::{MessageDeclaration, message};
use super::sheet_error::{SheetError, finite, length};
use super::vector::Vector3;
use cullet_model::{TornPiece, WindowLedger, WindowOutcome};

message! {
    /// A stretch of time in which a sheet was solved, and what came of it.
    SheetWindow {
        /// Number of the sheet.
        "1" [uint32] sheet: u32,
        /// Steps taken before it.
        "2" [uint64] first_step: u64,
        /// Steps in it.
        "3" [uint32] steps: u32,
        /// Simulated time at its end \[s\].
        "4" [double] time: f64,
        /// Digest of the problem, 32 bytes.
        "5" [bytes = "vec"] job: Vec<u8>,
        /// Digest of the state at its end, 32 bytes.
        "6" [bytes = "vec"] state: Vec<u8>,
        /// How far apart the world and the window have the rigid bodies in its reach at its end, at
        /// most \[m\].
        "7" [double] gap: f64,
        /// How often it was solved until that was little.
        "8" [uint32] solved: u32,
        /// True if the rigid bodies were not given what the sheet did to them.
        "9" [bool] one_way: bool,
        /// What came and went in it.
        "10" [message, optional] ledger: Option<SheetLedger>,
        /// The parts that the sheet has come to, by number.
        "11" [message, repeated] pieces: Vec<SheetPiece>,
        /// What only the family knows.
        "12" [message, repeated] figures: Vec<ReportFigure>,
        /// What the detectors noticed and let pass.
        "13" [string, repeated] warnings: Vec<String>,
    }
}

message! {
    /// A part of a sheet that holds together by itself.
    #[derive(Copy)]
    SheetPiece {
        /// Its number, which it keeps while it does not come apart; 0 is the sheet at its start.
        "1" [uint32] number: u32,
        /// The piece that it came from.
        "2" [uint32] parent: u32,
        /// Steps taken before it came to be.
        "3" [uint64] born: u64,
        /// Mass \[kg\].
        "4" [double] mass: f64,
        /// Area at rest \[m²\].
        "5" [double] area: f64,
        /// True if it is at rest, and not solved until something comes near.
        "6" [bool] frozen: bool,
    }
}

message! {
    /// What came and went in a window. Energies are counted with velocities at mid-step.
    #[derive(Copy)]
    SheetLedger {
        /// Mass at its end, with what the sheet has taken up \[kg\].
        "1" [double] mass: f64,
        /// Momentum at its end \[kg·m/s\].
        "2" [message, optional] momentum: Option<Vector3>,
        /// Angular momentum about the world's origin at its end \[kg·m²/s\].
        "3" [message, optional] angular_momentum: Option<Vector3>,
        /// Impulses on it, less what its momentum grew by \[kg·m/s\].
        "4" [message, optional] momentum_residual: Option<Vector3>,
        /// Kinetic energy at its end \[J\].
        "5" [double] kinetic: f64,
        /// Energy of stretched bonds at its end \[J\].
        "6" [double] stretching: f64,
        /// Energy of bending at its end \[J\].
        "7" [double] bending: f64,
        /// Work of separation in it \[J\].
        "8" [double] broken: f64,
        /// Plastic work in it \[J\].
        "9" [double] plastic: f64,
        /// What inner damping took in it \[J\].
        "10" [double] damped: f64,
        /// Work of the air on the sheet \[J\].
        "11" [double] air: f64,
        /// Work of grips and pins on it \[J\].
        "12" [double] grips: f64,
        /// Work of gravity on it \[J\].
        "13" [double] gravity: f64,
        /// Work of rigid bodies on it \[J\].
        "14" [double] bodies: f64,
        /// Work of what it took up or lost, through stiffness that changed \[J\].
        "15" [double] quantity_work: f64,
        /// Energy that is there and should not be \[J\].
        "16" [double] residual: f64,
        /// Integral of the quantity that diffuses, at its end.
        "17" [double] quantity: f64,
        /// What sources and sinks added to that integral in it.
        "18" [double] quantity_in: f64,
        /// Area of cracks at rest so far, length times thickness \[m²\].
        "19" [double] torn_area: f64,
    }
}

pub(super) fn declarations() -> Vec<MessageDeclaration> {
    vec![SheetWindow::declaration(), SheetPiece::declaration(), SheetLedger::declaration()]
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

fn three(of: Option<Vector3>) -> [f64; 3] {
    of.map_or([0.0; 3], |v| [v.x, v.y, v.z])
}

impl From<&TornPiece> for SheetPiece {
    fn from(&TornPiece { number, parent, born, mass, area, frozen }: &TornPiece) -> Self {
        Self { number, parent, born, mass, area, frozen }
    }
}

impl From<&SheetPiece> for TornPiece {
    fn from(&SheetPiece { number, parent, born, mass, area, frozen }: &SheetPiece) -> Self {
        Self { number, parent, born, mass, area, frozen }
    }
}

impl From<&WindowLedger> for SheetLedger {
    fn from(of: &WindowLedger) -> Self {
        Self {
            mass: of.mass,
            momentum: Some(vector(of.momentum)),
            angular_momentum: Some(vector(of.angular_momentum)),
            momentum_residual: Some(vector(of.momentum_residual)),
            kinetic: of.kinetic,
            stretching: of.stretching,
            bending: of.bending,
            broken: of.broken,
            plastic: of.plastic,
            damped: of.damped,
            air: of.air,
            grips: of.grips,
            gravity: of.gravity,
            bodies: of.bodies,
            quantity_work: of.quantity_work,
            residual: of.residual,
            quantity: of.quantity,
            quantity_in: of.quantity_in,
            torn_area: of.torn_area,
        }
    }
}

impl From<&SheetLedger> for WindowLedger {
    fn from(of: &SheetLedger) -> Self {
        Self {
            mass: of.mass,
            momentum: three(of.momentum),
            angular_momentum: three(of.angular_momentum),
            momentum_residual: three(of.momentum_residual),
            kinetic: of.kinetic,
            stretching: of.stretching,
            bending: of.bending,
            broken: of.broken,
            plastic: of.plastic,
            damped: of.damped,
            air: of.air,
            grips: of.grips,
            gravity: of.gravity,
            bodies: of.bodies,
            quantity_work: of.quantity_work,
            residual: of.residual,
            quantity: of.quantity,
            quantity_in: of.quantity_in,
            torn_area: of.torn_area,
        }
    }
}

impl SheetLedger {
    /// Its numbers, each with its name and unit, in the order of the message; of a vector its three
    /// components.
    #[must_use]
    pub fn numbers(&self) -> Vec<(String, &'static str, f64)> {
        let one = |name: &str, unit, value| (name.to_owned(), unit, value);
        let each = |name: &str, unit, of: Option<Vector3>| {
            ["x", "y", "z"]
                .map(|axis| format!("{name}_{axis}"))
                .into_iter()
                .zip(three(of))
                .map(move |(name, value)| (name, unit, value))
        };
        let mut all = vec![one("mass", "kg", self.mass)];
        all.extend(each("momentum", "kg·m/s", self.momentum));
        all.extend(each("angular_momentum", "kg·m²/s", self.angular_momentum));
        all.extend(each("momentum_residual", "kg·m/s", self.momentum_residual));
        let energies = [
            ("kinetic", self.kinetic),
            ("stretching", self.stretching),
            ("bending", self.bending),
            ("broken", self.broken),
            ("plastic", self.plastic),
            ("damped", self.damped),
            ("air", self.air),
            ("grips", self.grips),
            ("gravity", self.gravity),
            ("bodies", self.bodies),
            ("quantity_work", self.quantity_work),
            ("residual", self.residual),
        ];
        all.extend(energies.map(|(name, value)| one(name, "J", value)));
        all.push(one("quantity", "1", self.quantity));
        all.push(one("quantity_in", "1", self.quantity_in));
        all.push(one("torn_area", "m²", self.torn_area));
        all
    }
}

impl SheetWindow {
    /// Takes over what came of a window.
    #[must_use]
    pub fn with(self, outcome: &WindowOutcome) -> Self {
        let figures = outcome.figures.iter().map(|figure| ReportFigure {
            name: figure.name.clone(),
            unit: figure.unit.clone(),
            value: figure.value,
        });
        Self {
            ledger: Some(SheetLedger::from(&outcome.ledger)),
            pieces: outcome.pieces.iter().map(SheetPiece::from).collect(),
            figures: figures.collect(),
            warnings: outcome.warnings.clone(),
            ..self
        }
    }

    /// Steps taken at its end.
    #[must_use]
    pub fn end_step(&self) -> u64 {
        self.first_step.saturating_add(u64::from(self.steps))
    }

    /// Its ledger, where all of it is sound.
    ///
    /// # Errors
    /// What is not: no ledger, a number that is none, a digest that is not 32 bytes.
    pub fn checked_ledger(&self) -> Result<WindowLedger, SheetError> {
        length("job", self.job.len(), 32)?;
        length("state", self.state.len(), 32)?;
        finite("time", &[self.time])?;
        finite("gap", &[self.gap])?;
        let ledger = self.ledger.as_ref().ok_or(SheetError::Missing { part: "ledger" })?;
        let numbers: Vec<f64> = ledger.numbers().into_iter().map(|(.., value)| value).collect();
        finite("the ledger", &numbers)?;
        let pieces: Vec<f64> = self.pieces.iter().flat_map(|of| [of.mass, of.area]).collect();
        finite("pieces", &pieces)?;
        Ok(WindowLedger::from(ledger))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_comes_back_whole() {
        let momentum = [1.0, 2.0, 3.0];
        let ledger = WindowLedger { mass: 0.2, momentum, torn_area: 3e-6, ..Default::default() };
        let outcome = WindowOutcome { ledger, ..WindowOutcome::default() };
        let (job, state) = (vec![1; 32], vec![2; 32]);
        let window = SheetWindow { job, state, steps: 4, first_step: 8, ..SheetWindow::default() };
        let window = window.with(&outcome);
        assert_eq!(window.checked_ledger(), Ok(ledger));
        assert_eq!(window.end_step(), 12);
        let numbers = window.ledger.as_ref().expect("a ledger").numbers();
        // Each number of the ledger once: 16 that are one, three that are three.
        assert_eq!(numbers.len(), 25);
        assert_eq!(numbers[2], ("momentum_y".to_owned(), "kg·m/s", 2.0));
        let short = SheetWindow { state: vec![2; 31], ..window.clone() };
        let text = short.checked_ledger().expect_err("is short").to_string();
        assert_eq!(text, "state has 31 entries, 32 are needed");
        let wild = SheetWindow { gap: f64::NAN, ..window };
        assert!(wild.checked_ledger().is_err());
    }
}
