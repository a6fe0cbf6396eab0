//! Figures of what directed a run.

use cullet_record::DirectedTotals;

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
    rows
}
