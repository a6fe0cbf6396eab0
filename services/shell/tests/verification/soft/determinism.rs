//! A window is a pure function: neither the cut into windows nor the number of threads changes a
//! bit, and states of other shells are refused.

use super::harness::{RUBBER, TEARS, free_ball, grip_x, prepare, setup, sheet, solve};
use cullet_geometry::Vec3;
use cullet_model::{BodyCut, Continuum, ContinuumSetup, SoftBody, Window, WindowOutcome};
use cullet_shell::SoftShellWindow;
use std::sync::Arc;

/// A notched sheet that is pulled apart, with a ball on it.
fn torn() -> SoftBody {
    let mut body = sheet([0.24, 0.24, 4e-3], 0.02, TEARS, RUBBER);
    let pull = |way: f64| vec![(0.25, Vec3::new(way, 0.0, 0.0))];
    body.grips = vec![grip_x(-1.0, -0.09, pull(-0.05)), grip_x(0.09, 1.0, pull(0.05))];
    body.cuts = vec![notch(-1.0, -0.05)];
    body.damping = 0.1;
    body
}

/// A cut along y in the plane x = 0.
fn notch(from: f64, to: f64) -> BodyCut {
    let corner = |y: f64, z: f64| Vec3::new(1e-6, y, z);
    BodyCut {
        corners: vec![corner(from, -1.0), corner(to, -1.0), corner(to, 1.0), corner(from, 1.0)],
    }
}

fn gravity() -> Vec3 {
    Vec3::new(0.0, 0.0, -9.81)
}

fn ball() -> cullet_model::Proxy {
    free_ball(0.02, 0.02, Vec3::new(0.03, 0.06, 0.05), Vec3::new(0.0, 0.0, -1.0))
}

fn whole(setup: &ContinuumSetup) -> WindowOutcome {
    solve(&prepare(setup), None, 0, 60, vec![ball()])
}

/// A shell takes memory by its points: the cache of prepared bodies counts on it.
#[test]
fn memory_goes_with_the_number_of_points() {
    let of = |side: f64| {
        let prepared =
            prepare(&setup(sheet([side, side, 2e-3], 0.01, TEARS, RUBBER), Vec3::zeros()));
        SoftShellWindow::bytes(&prepared) as f64 / (side * side / 2.5e-5)
    };
    let [few, many] = [0.2, 0.4].map(of);
    assert!((0.8..1.1).contains(&(many / few)), "{few} and {many} bytes a point");
    assert!((500.0..10_000.0).contains(&many), "{many} bytes a point");
}

#[test]
fn threads_change_no_bit() {
    let setup = setup(torn(), gravity());
    let outcomes = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| whole(&setup))
    });
    assert!(outcomes[0].ledger.torn_area > 0.0, "nothing has torn");
    assert_eq!(outcomes[0], outcomes[1]);
}

#[test]
fn windows_in_halves_give_the_same_bits() {
    let mut body = torn();
    // A free ball's window ends with its own numbers; a led one is the same in both.
    body.air.density = 1.2;
    body.air.drag = 1.0;
    let setup = setup(body, gravity());
    let prepared = prepare(&setup);
    let whole = solve(&prepared, None, 0, 60, vec![]);
    let mut state = None::<Vec<u8>>;
    for (first, steps) in [(0, 7), (7, 23), (30, 11), (41, 19)] {
        let part = solve(&prepared, state.as_deref(), first, steps, vec![]);
        state = Some(part.state);
    }
    assert!(whole.ledger.torn_area > 0.0, "nothing has torn");
    assert!(whole.surfaces.len() > 1, "no surface has come apart");
    assert!(whole.state == state.unwrap(), "states differ");
}

#[test]
fn states_of_other_shells_and_broken_ones_are_refused() {
    let setup = setup(torn(), gravity());
    let prepared = prepare(&setup);
    let outcome = solve(&prepared, None, 0, 50, vec![]);
    let open = |prepared: &Arc<_>, state: &[u8], first_step: u64| {
        let window =
            Window { first_step, steps: 1, frame_every: 0, proxies: vec![], retired: None };
        SoftShellWindow::open(Arc::clone(prepared), Some(state), window)
    };
    assert!(open(&prepared, &outcome.state, 50).is_ok());
    assert!(open(&prepared, &outcome.state, 49).is_err());
    for length in [0, 1, 9, 17, 400, outcome.state.len() / 2, outcome.state.len() - 1] {
        let why = open(&prepared, &outcome.state[..length], 50).unwrap_err().to_string();
        assert!(why.contains("cut short"), "{length}: {why}");
    }
    let mut long = outcome.state.clone();
    long.push(0);
    assert!(open(&prepared, &long, 50).unwrap_err().to_string().contains("goes on"));
    let mut foreign = torn();
    foreign.material.young *= 1.01;
    let other = prepare(&super::harness::setup(foreign, gravity()));
    let why = open(&other, &outcome.state, 50).unwrap_err().to_string();
    assert!(why.contains("another shell"), "{why}");
    // Whatever byte is turned, it is refused or taken, and does no harm.
    for at in (17..outcome.state.len()).step_by(97) {
        let mut bent = outcome.state.clone();
        bent[at] ^= 0x55;
        let _ = open(&prepared, &bent, 50);
    }
}
