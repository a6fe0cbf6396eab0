//! Metal that flows: a bar that is pulled, and Taylor's that hits a wall.

use super::specimens::hold;

#[test]
fn metal_flows_as_it_must() {
    hold(&["c6-bar", "t1-taylor", "t2-punch"]);
}
