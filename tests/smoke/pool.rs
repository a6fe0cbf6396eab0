//! A pool of real processes: the death of a worker costs time and no result.

use crate::common;

use common::farm::{Farm, Role};
use common::{Cullet, LONGER, corpus, fetched, quiet_digest, unique, until};
use std::time::Duration;

/// Longest wait for anything here.
const LIMIT: Duration = Duration::from_secs(120);

#[test]
fn a_farm_that_loses_a_solver_and_a_worker_has_the_bits_of_a_quiet_run() {
    let _left = common::left::NobodyLeft::watch();
    let mut farm = Farm::start(unique("smoke"), 2);
    let endpoint = farm.door.1.clone();
    let call = ["submit", &corpus("drop.toml"), "--detach", "--connect", &endpoint];
    let said = Cullet::new(&call).args(&LONGER).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let run = said.stdout.trim().to_owned();
    let mut killed = None;
    until("a solver is killed", LIMIT, || {
        killed = (0..2).find(|&worker| farm.kill_job(worker));
        killed.is_some()
    });
    // The worker that is killed is the other one, so that both kinds of loss are met.
    farm.kill(Role::Worker(1 - killed.expect("a worker")));
    farm.tend();
    let waited = Cullet::new(&["wait", &run, "--connect", &endpoint]).output();
    assert_eq!(waited.code, 0, "{}", waited.stderr);
    assert_eq!(fetched(&run, &["--connect", &endpoint]), quiet_digest(&LONGER));
    farm.leave();
    assert!(farm.left().is_empty(), "processes are left: {:?}", farm.left());
}
