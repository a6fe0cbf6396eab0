//! What came of sheets, added up from their windows.

use cullet_proto::recording::{SheetFrame, SheetLedger, SheetWindow};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// What came of all sheets of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SheetTotals {
    /// Sheets.
    pub sheets: u64,
    /// Windows of their time that were solved.
    pub windows: u64,
    /// Parts that they came to.
    pub pieces: u64,
    /// Those of them that are crumbs: of less area than six of the points that sheets are made of.
    #[serde(default)]
    pub crumbs: u64,
    /// Area of their cracks at rest, length times thickness \[m²\].
    pub torn_area: f64,
    /// Energy in a window that should not be there, at most \[J\].
    pub energy_residual: f64,
    /// The same over all energy that was there and came and went in the window \[1\].
    pub energy_residual_rel: f64,
    /// How far apart the world and a window had the rigid bodies in its reach, at most \[m\].
    pub gap: f64,
}

/// Points below which a part is a crumb.
const CRUMB: f64 = 6.0;
/// The figure of a window that says of how many points its sheet is made.
const POINTS: &str = "points";

/// How many of the pieces that a window ends with are crumbs, of less area than six points; 0 where
/// the window does not say of how many points the sheet is made.
fn crumbs(window: &SheetWindow) -> usize {
    let points = window.figures.iter().find(|it| it.name == POINTS).map(|it| it.value);
    let area: f64 = window.pieces.iter().map(|piece| piece.area).sum();
    let least = points.filter(|&points| points > 0.0).map_or(0.0, |points| area / points * CRUMB);
    window.pieces.iter().filter(|piece| piece.area < (1.0 - 1e-9) * least).count()
}

/// Of how many pieces there are all, and how many of these are crumbs; as text "24 pieces, 22 of
/// them crumbs".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PieceCount {
    /// All of them, which the expectation `sheet_pieces` bounds.
    pub pieces: u64,
    /// Those of less area than six points.
    pub crumbs: u64,
}

impl PieceCount {
    /// Counts the pieces that a window ends with.
    #[must_use]
    pub fn of(window: &SheetWindow) -> Self {
        Self { pieces: window.pieces.len() as u64, crumbs: crumbs(window) as u64 }
    }

    /// Pieces that are more than crumbs.
    #[must_use]
    pub fn large(self) -> u64 {
        self.pieces - self.crumbs
    }

    /// This and another count together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { pieces: self.pieces + other.pieces, crumbs: self.crumbs + other.crumbs }
    }
}

impl fmt::Display for PieceCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pieces, crumbs } = self;
        let plural = if *pieces == 1 { "" } else { "s" };
        write!(f, "{pieces} piece{plural}")?;
        if *crumbs > 0 { write!(f, ", {crumbs} of them crumbs") } else { Ok(()) }
    }
}

/// What came of each sheet of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SheetCensus {
    sheets: BTreeMap<u32, SheetRow>,
}

/// What came of one sheet.
#[derive(Clone, Debug, Default, PartialEq)]
struct SheetRow {
    name: String,
    frames: u64,
    /// Windows whose rigid bodies were not given what the sheet did to them.
    one_way: u64,
    totals: SheetTotals,
}

/// All energy that is there at the end of a window, and all that came and went in it \[J\].
fn turnover(ledger: &SheetLedger) -> f64 {
    let there = [ledger.kinetic, ledger.stretching, ledger.bending];
    let went = [ledger.broken, ledger.plastic, ledger.damped, ledger.quantity_work];
    let worked = [ledger.air, ledger.grips, ledger.gravity, ledger.bodies];
    there.iter().chain(&went).chain(&worked).map(|energy| energy.abs()).sum()
}

impl SheetCensus {
    /// Takes in a frame.
    pub fn frame(&mut self, frame: &SheetFrame) {
        let row = self.sheets.entry(frame.sheet).or_default();
        row.name.clone_from(&frame.name);
        row.frames += 1;
    }

    /// Takes in a window.
    pub fn window(&mut self, window: &SheetWindow) {
        let row = self.sheets.entry(window.sheet).or_default();
        let (ledger, totals) = (window.ledger.unwrap_or_default(), &mut row.totals);
        let (residual, turnover) = (ledger.residual.abs(), turnover(&ledger));
        let share = if turnover > 0.0 { residual / turnover } else { 0.0 };
        totals.windows += 1;
        PieceCount { pieces: totals.pieces, crumbs: totals.crumbs } = PieceCount::of(window);
        totals.torn_area = ledger.torn_area;
        totals.energy_residual = totals.energy_residual.max(residual);
        totals.energy_residual_rel = totals.energy_residual_rel.max(share);
        totals.gap = totals.gap.max(window.gap);
        row.one_way += u64::from(window.one_way);
    }

    /// What came of all of them; nothing where there are none.
    #[must_use]
    pub fn totals(&self) -> Option<SheetTotals> {
        let mut all = SheetTotals { sheets: self.sheets.len() as u64, ..SheetTotals::default() };
        for SheetRow { totals: of, .. } in self.sheets.values() {
            all.windows += of.windows;
            all.pieces += of.pieces;
            all.crumbs += of.crumbs;
            all.torn_area += of.torn_area;
            all.energy_residual = all.energy_residual.max(of.energy_residual);
            all.energy_residual_rel = all.energy_residual_rel.max(of.energy_residual_rel);
            all.gap = all.gap.max(of.gap);
        }
        Some(all).filter(|all| all.sheets > 0)
    }

    /// A line a sheet, by number.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let line = |(number, row): (&u32, &SheetRow)| {
            let of = &row.totals;
            let name = if row.name.is_empty() { "without a frame" } else { &row.name };
            let one_way = match row.one_way {
                0 => String::new(),
                some => format!("; {some} of them one-way: bodies did not feel it"),
            };
            let pieces = PieceCount { pieces: of.pieces, crumbs: of.crumbs };
            format!(
                "sheet {number} ({name}): {pieces}, {:.3e} m² torn, {} frames, \
                 {} windows; energy off by {:.3e} J at most ({:.2} %), bodies by {:.3e} m{one_way}",
                of.torn_area,
                row.frames,
                of.windows,
                of.energy_residual,
                100.0 * of.energy_residual_rel,
                of.gap
            )
        };
        self.sheets.iter().map(line).collect()
    }
}
