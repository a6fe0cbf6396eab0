//! Tables (CSV) of sheets: a row a window, and a row a piece.

use crate::timeline::ExportTimeline;
use cullet_files::cells::quote_cell;
use cullet_proto::recording::{SheetLedger, SheetPiece};
use std::collections::BTreeMap;

/// The name of a column: of `momentum_x` in kg·m/s it is `momentum_x_kg_m_s`.
fn column(name: &str, unit: &str) -> String {
    match unit {
        "1" => name.to_owned(),
        unit => format!("{name}_{}", unit.replace(['·', '/'], "_").replace('²', "2")),
    }
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The windows with their ledgers, and the pieces as the last window has them that has them.
pub(crate) fn write(timeline: &ExportTimeline) -> [String; 2] {
    [windows(timeline), pieces(timeline)]
}

fn windows(timeline: &ExportTimeline) -> String {
    let numbers = SheetLedger::default().numbers();
    let names: Vec<String> = numbers.iter().map(|(name, unit, _)| column(name, unit)).collect();
    let mut text = format!(
        "sheet,number,first_step,steps,end_s,job,state,gap_m,solved,one_way,pieces,{},figures,\
         warnings\n",
        names.join(",")
    );
    for row in &timeline.windows {
        let of = &row.window;
        let ledger = of.ledger.unwrap_or_default().numbers();
        let ledger: Vec<String> = ledger.iter().map(|(.., value)| value.to_string()).collect();
        let figures = of.figures.iter().map(|it| format!("{} {} {}", it.name, it.value, it.unit));
        let cells = [
            quote_cell(&row.sheet),
            of.sheet.to_string(),
            of.first_step.to_string(),
            of.steps.to_string(),
            timeline.range.since(of.time).to_string(),
            hex(&of.job),
            hex(&of.state),
            of.gap.to_string(),
            of.solved.to_string(),
            of.one_way.to_string(),
            of.pieces.len().to_string(),
            ledger.join(","),
            quote_cell(&figures.collect::<Vec<_>>().join("; ")),
            quote_cell(&of.warnings.join("; ")),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

/// A piece as the last window has it that has it.
struct LastPiece<'a> {
    sheet: &'a str,
    piece: SheetPiece,
    /// The end of that window \[s\].
    time: f64,
}

fn pieces(timeline: &ExportTimeline) -> String {
    let mut last: BTreeMap<(u32, u32), LastPiece<'_>> = BTreeMap::new();
    for row in &timeline.windows {
        for &piece in &row.window.pieces {
            let time = timeline.range.since(row.window.time);
            let known = LastPiece { sheet: &row.sheet, piece, time };
            last.insert((row.window.sheet, piece.number), known);
        }
    }
    let mut text = "sheet,piece,parent,born_step,last_s,mass_kg,area_m2,frozen\n".to_owned();
    for LastPiece { sheet, piece: of, time } in last.values() {
        let cells = [
            quote_cell(sheet),
            of.number.to_string(),
            of.parent.to_string(),
            of.born.to_string(),
            time.to_string(),
            of.mass.to_string(),
            of.area.to_string(),
            of.frozen.to_string(),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
