//! Metal that flows: a bar that is pulled, and Taylor's that hits a wall.

use super::specimens::hold;

#[test]
fn metal_flows_as_it_must() {
    hold(&["c6-bar", "t1-taylor", "t2-punch"]);
}

/// Considère's greatest force, and a neck after it.
#[test]
fn a_bar_necks_when_it_must() {
    hold(&["c13-necking"]);
}

/// Far below its yield stress, by couples and forces at the ends.
#[test]
fn a_bar_stretches_bends_and_twists_as_it_must() {
    hold(&["c9-stretch", "c10-bend", "c12-twist"]);
}
