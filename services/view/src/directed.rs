//! Figures of what directed a run.

use cullet_record::{DirectedTotals, Shares};

/// What the scene directed, and neither a solver solved nor a law sampled.
pub(crate) fn directed_figures(directed: &DirectedTotals) -> Vec<(&'static str, String)> {
    let count = |count: u64| count.to_string();
    let mut rows = Vec::new();
    if directed.driven > 0 {
        rows.push(("directed: bodies on keyframes", count(directed.driven)));
        rows.push(("their work on others", format!("{:.4} J", directed.driven_work)));
    }
    if directed.joints > 0 {
        let (all, glue) = (directed.joints, directed.glue_joints);
        rows.push(("directed: joints and their strengths", format!("{all}, {glue} of glue")));
        rows.push(("joints broken", count(directed.joints_broken)));
        rows.push(("joints gone with their bodies", count(directed.joints_gone)));
        rows.push(("joints passed on to fragments", count(directed.joints_inherited)));
    }
    if directed.removed > 0 {
        rows.push(("directed: bodies removed", count(directed.removed)));
    }
    if directed.hits > 0 {
        rows.push(("directed: hits with settings of their own", count(directed.hits)));
    }
    if directed.painted > 0 {
        rows.push(("directed: bodies of painted strength", count(directed.painted)));
    }
    if directed.pieces > 0 {
        let [added, closed] =
            [directed.added_crack_area, directed.closed_crack_area].map(|a| format!("{a:.3e} m²"));
        rows.push(("directed: crack area added, at no cost of energy", added));
        rows.push(("directed: crack area closed, its energy spent", closed));
    }
    rows
}

/// What of the fragments was directed; nothing where nothing was.
pub(crate) fn directed_shares(shares: &Shares) -> Vec<(&'static str, String)> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let Some(directed) = &shares.directed else { return Vec::new() };
    vec![
        ("directed pieces, of those at the end", percent(directed.share)),
        ("share of them in the mass of pieces", percent(shares.directed_piece_mass())),
        ("directed share of the crack area", percent(directed.crack_area)),
    ]
}
