//! Bodies that move as they deform: soft shells and soft solids.

use super::{errors_of, from_text};
use cullet_geometry::Vec3;
use cullet_model::{BodyRegion, ContinuumBody, SoftBody, SoftLaw};

const FOAM: &str = "[[material]]\nname = \"foam\"\ndensity = 100\nyoung = \"100 kPa\"\n\
                    poisson = 0.2\nstrength = \"20 kPa\"\nfracture_energy = 50\n";

fn bar(body: &str, dynamic: &str) -> String {
    format!(
        "{FOAM}[[body]]\nname = \"bar\"\nmaterial = \"foam\"\nposition = [0, 0, 1]\n\
         shape = {{ kind = \"box\", size = [0.4, 0.05, 0.05] }}\n{body}\n\
         [body.dynamic]\n{dynamic}\n"
    )
}

fn soft(text: &str) -> SoftBody {
    let scene = from_text(text, &[]).unwrap_or_else(|why| panic!("{why}"));
    assert!(scene.bodies.is_empty());
    match &scene.moving[..] {
        [one] => match &one.body {
            ContinuumBody::Soft(body) => body.clone(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_dynamic_body_is_no_rigid_one_and_takes_its_solvers_law() {
    let solid = soft(&bar("solver = \"peridynamics\"", ""));
    assert!(matches!(solid.law, SoftLaw::Bonded(bonds) if bonds.breaks));
    assert_eq!((solid.spacing, solid.pose.translation.vector), (0.4 / 24.0, Vec3::z()));
    let whole = soft(&bar("solver = \"peridynamics\"\nbreakable = false", ""));
    assert!(matches!(whole.law, SoftLaw::Bonded(bonds) if !bonds.breaks));
    let shell = soft(&bar("solver = \"shell\"\nresolution = { spacing = 0.01 }", "damping = 0.3"));
    assert!(matches!(shell.law, SoftLaw::Shell { hardening: None, breaks: true }));
    assert_eq!((shell.spacing, shell.damping), (0.01, 0.3));
}

#[test]
fn grips_and_cuts_are_in_the_frame_of_the_shape() {
    let text = bar(
        "solver = \"peridynamics\"",
        "grip = [{ region = { centre = [0.2, 0, 0], radius = 0.01 }, velocity = [0, 0, 2] }]\n\
         cuts = [[[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]]]",
    );
    let body = soft(&text);
    // The origin of a box stands in its middle.
    assert_eq!(body.grips[0].region, BodyRegion::Ball { centre: 0.2 * Vec3::x(), radius: 0.01 });
    let (time, way) = body.grips[0].path[1];
    assert!((way / time - 2.0 * Vec3::z()).norm() < 1e-12);
    assert!(body.cuts[0].parts(&(-0.1 * Vec3::x()), &(0.1 * Vec3::x())));
}

#[test]
fn what_no_dynamic_body_can_be_is_said_with_its_place() {
    let peri = "solver = \"peridynamics\"";
    for (body, dynamic, place, what) in [
        ("", "", "body.bar.solver", "\"shell\" or \"peridynamics\""),
        ("solver = \"brittle\"", "", "body.bar.solver", "\"shell\" or \"peridynamics\""),
        ("solver = \"peridynamics\"\nfixed = true", "", "body.bar.fixed", "a `grip` holds it"),
        (peri, "grip = [{ region = {} }]", "grip", "`centre` and `radius`"),
        (
            peri,
            "grip = [{ region = { low = [1, 0, 0], high = [0, 0, 0] } }]",
            "grip",
            "at most `high`",
        ),
        (peri, "cuts = [[[0, 0, 0], [1, 0, 0], [2, 0, 0]]]", "cuts", "has no area"),
        (peri, "cuts = [[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]]]", "cuts", "in a plane"),
        (peri, "pace = { softer = 1, heavier = 2 }", "pace", "one of them"),
        ("solver = \"shell\"\nresolution = { spacing = 1e-7 }", "", "dynamic", "spacing"),
    ] {
        let errors = errors_of(&bar(body, dynamic), &[]);
        assert!(errors.contains(place) && errors.contains(what), "{errors}");
    }
    let stack = "[[stack]]\nname = \"pile\"\ncount = 2\noffset = [0, 0, 2]\n\
                 body = { material = \"foam\", \
                 solver = \"shell\", shape = { kind = \"box\", size = [1, 1, 1] }, dynamic = {} }";
    let errors = errors_of(&format!("{FOAM}{stack}"), &[]);
    assert!(errors.contains("only a single `[[body]]`"), "{errors}");
}

/// Pieces of soft shells and of soft solids at rest may become rigid bodies.
#[test]
fn dynamic_bodies_retire_where_they_are_asked_to() {
    for solver in ["shell", "peridynamics"] {
        let asked = |dynamic: &str| {
            let text = bar(&format!("solver = \"{solver}\""), dynamic);
            from_text(&text, &[]).unwrap_or_else(|why| panic!("{why}")).moving[0].retire
        };
        assert_eq!((asked(""), asked("retire = true")), (false, true), "{solver}");
    }
}

/// Rubber bears ten times its modulus: no rigid body of it breaks, but a sheet or soft body may.
#[test]
fn what_stretches_far_may_tear_as_it_moves_but_not_as_a_rigid_body() {
    let stretchy = FOAM.replace("20 kPa", "1 MPa");
    let body = |more: &str| {
        format!(
            "{stretchy}[[body]]\nname = \"bar\"\nmaterial = \"foam\"\n\
             shape = {{ kind = \"box\", size = [1, 1, 1] }}\n{more}"
        )
    };
    let errors = errors_of(&body(""), &[]);
    assert!(errors.contains("strength over Young's modulus"), "{errors}");
    soft(&body("solver = \"peridynamics\"\ndynamic = {}\n"));
}
