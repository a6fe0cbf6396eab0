//! What directs a shot: driven bodies, joints, glue, fields, bounds, groups.

use super::{SMALL, errors_of, from_text};
use crate::Scene;
use crate::directions::{FieldLaw, GlueStrength, SceneJoint};
use crate::format::JointForm;
use cullet_geometry::Vec3;
use cullet_world::PathInterpolation;

fn with(more: &str) -> String {
    format!("{SMALL}{more}")
}

fn loaded(more: &str) -> Scene {
    from_text(&with(more), &[]).unwrap_or_else(|why| panic!("{why}\n{more}"))
}

/// Each text is refused with all of these words.
fn refused(cases: &[(&str, &[&str])]) {
    for (more, words) in cases {
        let said = errors_of(&with(more), &[]);
        for word in *words {
            assert!(said.contains(word), "no \"{word}\" in:\n{said}\nof\n{more}");
        }
    }
}

/// A cone's centroid is a quarter up from its base: keyframes place its origin all the same.
#[test]
fn a_driven_body_goes_through_its_keyframes() {
    let cone = "[[body]]\nname = \"cone\"\nmaterial = \"granite\"\nposition = [0, 3, 0]\n\
                shape = { kind = \"cone\", radius = 0.1, height = 0.4 }\n\
                interpolation = \"smooth\"\nkeyframes = [\n\
                { at = \"0.5 s\", position = [0, 5, 1] },\n\
                { at = 1, rotation = { axis = [1, 0, 0], degrees = 180 } },\n]\n";
    let scene = loaded(cone);
    let body = &scene.bodies[2];
    let path = body.drive.as_ref().expect("it is driven");
    assert_eq!(path.interpolation(), PathInterpolation::Smooth);
    assert!(!body.breakable && !body.fixed, "granite breaks, but no driven body does");
    // It stands at its first keyframe; without a position there is the body's own.
    let off = body.pose.translation.vector - Vec3::new(0.0, 5.0, 0.9);
    assert!(off.norm() < 1e-9, "{off}");
    assert_eq!(path.at(0.0), body.pose);
    let off = path.at(2.0).translation.vector - Vec3::new(0.0, 3.0, 0.1);
    assert!(off.norm() < 1e-9, "{off}");
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!(crate::rigid::spec(body).driven.is_some());
}

#[test]
fn what_no_driven_body_can_be_is_said_with_its_place() {
    let body = |more: &str| {
        format!(
            "[[body]]\nname = \"arm\"\nmaterial = \"steel\"\nposition = [0, 0, 4]\n\
             shape = {{ kind = \"box\", size = [1, 1, 1] }}\n{more}\n"
        )
    };
    let key = "keyframes = [{ at = 0 }]";
    for (more, words) in [
        ("keyframes = []", ["body.arm.keyframes", "at least one keyframe"]),
        (
            "keyframes = [{ at = 1 }, { at = 1 }]",
            ["body.arm.keyframes[1].at", "later than the keyframe before, at 1 s; it is 1 s"],
        ),
        ("keyframes = [{ at = 700 }]", ["body.arm.keyframes[0].at", "at most 600 s"]),
        (
            "keyframes = [{ at = 0 }, { at = 0.001, position = [0, 0, 40] }]",
            ["body.arm.keyframes[1].position", "36000 m/s; at most 10000 m/s"],
        ),
        (
            "keyframes = [{ at = 0, position = [0, 0, 200000] }]",
            ["body.arm.keyframes[0].position", "at most 100000 m"],
        ),
        (
            "keyframes = [{ at = 0, rotation = { axis = [0, 0, 1] } }]",
            ["body.arm.keyframes[0].rotation", "`degrees` is missing"],
        ),
        ("interpolation = \"smooth\"", ["body.arm.interpolation", "with `keyframes`"]),
        ("interpolation = \"cubic\"", ["body.arm.interpolation", "linear, smooth"]),
        (&format!("{key}\nfixed = true"), ["body.arm.fixed", "not both"]),
        (&format!("{key}\nbreakable = true"), ["body.arm.breakable", "does not break"]),
        (&format!("{key}\nvelocity = [1, 0, 0]"), ["body.arm.velocity", "keyframes say"]),
        (&format!("{key}\nspin = [1, 0, 0]"), ["body.arm.spin", "keyframes say"]),
        (
            &format!("{key}\nsolver = \"peridynamics\"\ndynamic = {{}}"),
            ["body.arm.dynamic", "a driven body is rigid"],
        ),
    ] {
        let said = errors_of(&with(&body(more)), &[]);
        assert!(words.iter().all(|word| said.contains(word)), "{words:?} not in:\n{said}");
    }
    let stack = "[[stack]]\nname = \"s\"\ncount = 2\noffset = [0, 0, 2]\n[stack.body]\n\
                 material = \"steel\"\nshape = { kind = \"box\", size = [1, 1, 1] }\n\
                 position = [0, 9, 9]\nkeyframes = [{ at = 0 }]\n";
    refused(&[(stack, &["stack.s.body.keyframes", "only a single `[[body]]`"])]);
}

fn joint(more: &str) -> SceneJoint {
    loaded(&format!("[[joint]]\n{more}\n")).directions.joints[0].clone()
}

#[test]
fn joints_have_the_ends_that_they_are_given() {
    let rope = joint("kind = \"rope\"\nbetween = [\"world\", \"cube\"]\nat = [0, 0, 3]");
    // A rope is as long as its ends are apart, and tied to the centre of mass.
    assert_eq!((rope.bodies, rope.length), ([None, Some(0)], 2.0));
    assert_eq!(rope.anchors, [Vec3::new(0.0, 0.0, 3.0), Vec3::z()]);
    assert!(rope.collide && rope.force.is_none());
    let tied = joint(
        "kind = \"rope\"\nbetween = [\"ball\", \"cube\"]\nto = [0.1, 0, 1]\nlength = \"2 m\"\n\
         force = \"3 kN\"\ncollide = false",
    );
    assert!(tied.anchors[0].norm() < 1e-12 && tied.anchors[1].x == 0.1, "{:?}", tied.anchors);
    assert_eq!((tied.length, tied.force, tied.collide), (2.0, Some(3000.0), false));
    let hinge = joint(
        "kind = \"hinge\"\nbetween = [\"cube\", \"world\"]\nat = [0, 0, 1]\naxis = [0, 3, 0]\n\
         torque = \"2 kN m\"",
    );
    assert_eq!((hinge.kind, hinge.axis, hinge.torque), (JointForm::Hinge, Vec3::y(), Some(2000.0)));
    let rigid = joint("kind = \"rigid\"\nbetween = [\"world\", \"cube\"]");
    assert_eq!(rigid.anchors, [Vec3::z(); 2], "at the centre of the one that is there");
}

/// Nothing can break the bodies here, but joints can break.
#[test]
fn a_scene_with_joints_is_not_said_to_break_nothing() {
    let warned = |more: &str| loaded(more).warnings.join("\n");
    let steel = ["body.cube.material=steel"];
    let plain = from_text(SMALL, &steel).expect("loads").warnings.join("\n");
    assert!(plain.contains("nothing in this scene can break"), "{plain}");
    let rope = "[[joint]]\nkind = \"rope\"\nbetween = [\"world\", \"cube\"]\nat = [0, 0, 3]\n";
    let joined = from_text(&with(rope), &steel).expect("loads");
    assert_eq!(joined.warnings, Vec::<String>::new());
    // However the wind blows, steel does not break.
    let wind = "[[field]]\nkind = \"wind\"\nvelocity = [9, 0, 0]\n";
    let blown = from_text(&with(wind), &steel).expect("loads").warnings.join("\n");
    assert!(blown.contains("nothing in this scene can break"), "{blown}");
    assert_eq!(warned(wind), "", "granite may, wherever the wind takes it");
}

#[test]
fn what_is_wrong_with_a_joint_is_said_with_its_place() {
    let cases: [(&str, &[&str]); 14] = [
        ("kind = \"ball\"\nbetween = [\"cube\"]\nat = [0, 0, 1]", &["joint[0].between", "2"]),
        (
            "kind = \"ball\"\nbetween = [\"cube\", \"bal\"]\nat = [0, 0, 1]",
            &["joint[0].between[1]", "no body \"bal\"", "did you mean `ball`"],
        ),
        (
            "kind = \"ball\"\nbetween = [\"cube\", \"cube\"]\nat = [0, 0, 1]",
            &["joint[0].between", "two bodies that differ"],
        ),
        (
            "kind = \"ball\"\nbetween = [\"world\", \"world\"]\nat = [0, 0, 1]",
            &["joint[0].between", "two bodies that differ"],
        ),
        ("kind = \"ball\"\nbetween = [\"cube\", \"ball\"]", &["joint[0]", "`at` is missing"]),
        (
            "kind = \"hinge\"\nbetween = [\"cube\", \"ball\"]\nat = [0, 0, 1]",
            &["joint[0]", "`axis` is missing"],
        ),
        (
            "kind = \"hinge\"\nbetween = [\"cube\", \"ball\"]\nat = [0, 0, 1]\naxis = [0, 0, 0]",
            &["joint[0].axis", "length above 1e-6"],
        ),
        ("kind = \"rope\"\nbetween = [\"cube\", \"world\"]", &["joint[0]", "`to` is missing"]),
        (
            "kind = \"rope\"\nbetween = [\"cube\", \"ball\"]\nlength = 0",
            &["joint[0].length", "above 0 m; it is 0 m"],
        ),
        (
            "kind = \"rope\"\nbetween = [\"cube\", \"ball\"]\nlength = 0.9",
            &["joint[0].length", "at least 1 m, the distance of its ends; it is 0.9 m"],
        ),
        (
            "kind = \"rope\"\nbetween = [\"cube\", \"ball\"]\ntorque = 1",
            &["joint[0].torque", "bear no moment"],
        ),
        (
            "kind = \"rigid\"\nbetween = [\"cube\", \"ball\"]\nlength = 2\ncollide = true",
            &["joint[0].length", "for a rope", "joint[0].collide"],
        ),
        (
            "kind = \"rigid\"\nbetween = [\"cube\", \"ball\"]\nforce = 0",
            &["joint[0].force", "above 0 N"],
        ),
        ("kind = \"weld\"\nbetween = [\"cube\", \"ball\"]", &["joint[0].kind", "rigid, hinge"]),
    ];
    for (more, words) in cases {
        refused(&[(&format!("[[joint]]\n{more}\n"), words)]);
    }
    let fixed = "[[body]]\nname = \"floor\"\nshape = { kind = \"box\", size = [1, 1, 1] }\n\
                 position = [0, 0, -9]\nmaterial = \"granite\"\nfixed = true\n\
                 [[joint]]\nkind = \"rigid\"\nbetween = [\"floor\", \"world\"]\n";
    refused(&[(fixed, &["joint[0].between", "free to move"])]);
}

const BRICKS: &str = r#"
[[stack]]
name = "brick"
count = 3
offset = [0, 0, 0.1]

[stack.body]
shape = { kind = "box", size = [0.2, 0.1, 0.1] }
position = [5, 0, 0.05]
material = "brick"
group = "masonry"

[[body]]
name = "lintel"
shape = { kind = "box", size = [0.2, 0.1, 0.1] }
position = [5, 0, 0.35]
material = "granite"
group = "masonry"
"#;

#[test]
fn glue_takes_names_generators_and_groups_each_body_once() {
    let glue =
        |more: &str| loaded(&format!("{BRICKS}[[glue]]\n{more}\n")).directions.glue[0].clone();
    let all =
        glue("bodies = [\"masonry\", \"brick\", \"brick-1\"]\ntensile = \"0.2 MPa\"\nshear = 3e5");
    // Bodies of the scene come first, then stacks.
    assert_eq!(all.bodies, [2, 3, 4, 5]);
    assert_eq!(all.strength, GlueStrength::Area { tensile: 2e5, shear: 3e5 });
    assert_eq!(all.gap, 1e-3);
    let pair = glue("bodies = [\"brick\"]\nforce = \"2 kN\"\ntorque = \"5 N m\"\ngap = \"1 cm\"");
    assert_eq!(pair.bodies, [3, 4, 5]);
    assert_eq!(pair.strength, GlueStrength::Pair { force: 2000.0, torque: Some(5.0) });
    assert_eq!(pair.gap, 0.01);
}

#[test]
fn what_is_wrong_with_glue_and_groups_is_said_with_its_place() {
    let glue = |more: &str| format!("{BRICKS}[[glue]]\n{more}\n");
    refused(&[
        (&glue("bodies = [\"brik\"]\nforce = 1"), &["glue[0].bodies[0]", "did you mean `brick`"]),
        (&glue("bodies = [\"lintel\"]\nforce = 1"), &["glue[0].bodies", "these are 1"]),
        (&glue("bodies = [\"brick\"]"), &["glue[0]", "`force`, or `tensile` and `shear`"]),
        (&glue("bodies = [\"brick\"]\ntensile = 1"), &["glue[0]", "`tensile` and `shear`"]),
        (&glue("bodies = [\"brick\"]\nforce = 1\nshear = 1"), &["glue[0]", "`force`, or"]),
        (
            &glue("bodies = [\"brick\"]\ntensile = 1\nshear = 1\ntorque = 2"),
            &["glue[0].torque", "with `force`"],
        ),
        (&glue("bodies = [\"brick\"]\nforce = 1\ngap = 0"), &["glue[0].gap", "above 0 m"]),
        (&BRICKS.replace("\"masonry\"", "\"ball\""), &["body.lintel.group", "is called \"ball\""]),
        (&BRICKS.replace("\"masonry\"", "\"a/b\""), &["stack.brick.body.group", "no slash"]),
    ]);
}

#[test]
fn fields_act_on_the_bodies_that_they_name() {
    let fields = "[[field]]\nkind = \"wind\"\nvelocity = [\"36 km/h\", 0, 0]\n\
                  bodies = [\"masonry\"]\n\
                  [[field]]\nkind = \"kill\"\npoint = [0, 0, -1]\nnormal = [0, 0, 2]\n\
                  [[field]]\nkind = \"turbulence\"\nstrength = 2\nrate = 3\n";
    let scene = loaded(&format!("{BRICKS}{fields}"));
    let [wind, kill, stirred] = &scene.directions.fields[..] else { panic!("three fields") };
    let names: Vec<&str> = wind.bodies.iter().flatten().map(String::as_str).collect();
    assert_eq!(names, ["brick-0", "brick-1", "brick-2", "lintel"]);
    let velocity = Vec3::new(10.0, 0.0, 0.0);
    assert_eq!(wind.law, FieldLaw::Wind { velocity, drag: 0.47, density: 1.2 });
    assert_eq!(kill.law, FieldLaw::Kill { point: -Vec3::z(), normal: Vec3::z() });
    let law = FieldLaw::Turbulence { strength: 2.0, size: 1.0, rate: 3.0, seed: 1 };
    assert_eq!((stirred.law, &stirred.bodies), (law, &None), "by the seed of the world");
    assert!(scene.is_directed() && !loaded("").is_directed());
}

#[test]
fn what_is_wrong_with_a_field_is_said_with_its_place() {
    for (more, words) in [
        ("kind = \"wind\"", ["field[0]", "`velocity` is missing: wind needs it"]),
        ("kind = \"wind\"\nvelocity = [2e4, 0, 0]", ["field[0].velocity", "at most 10000 m/s"]),
        ("kind = \"wind\"\nvelocity = [1, 0, 0]\nseed = 4", ["field[0].seed", "is not for wind"]),
        ("kind = \"attractor\"\nstrength = 1", ["field[0]", "`point` is missing"]),
        (
            "kind = \"attractor\"\nstrength = 1e5\npoint = [0, 0, 0]",
            ["field[0].strength", "at most 10000 m/s2"],
        ),
        ("kind = \"turbulence\"\nstrength = 1\nsize = 0", ["field[0].size", "at least 1e-6 m"]),
        (
            "kind = \"kill\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]",
            ["field[0].normal", "length above 1e-6"],
        ),
        ("kind = \"kill\"\npoint = [0, 0, 0]", ["field[0]", "`normal` is missing"]),
        (
            "kind = \"turbulence\"\nstrength = 1\nbodies = [\"cubes\"]",
            ["field[0].bodies[0]", "did you mean `cube`"],
        ),
    ] {
        refused(&[(&format!("[[field]]\n{more}\n"), &words[..])]);
    }
    let said = errors_of(SMALL, &["world.bounds={min=[0,0,0], max=[1,1,0]}"]);
    assert!(said.contains("world.bounds") && said.contains("along z they are 0 and 0 m"), "{said}");
}

/// A cube with a bar through it: the bar's part inside counts once.
#[test]
fn the_parts_of_a_body_are_one_closed_mesh() {
    let parts = "body.cube.parts=[\
                 { shape = { kind = \"box\", size = [0.2, 0.2, 0.2] } },\
                 { shape = { kind = \"box\", size = [0.4, 0.1, 0.1] }, position = [0.1, 0, 0],\
                   rotation = { axis = [0, 0, 1], degrees = 180 } }]";
    let text =
        SMALL.replace("shape = { kind = \"box\", size = [\"20 cm\", \"10 cm\", \"5 cm\"] }\n", "");
    let scene = from_text(&text, &[parts]).unwrap_or_else(|why| panic!("{why}"));
    let body = &scene.bodies[0];
    // The bar ends 0.3 m to the right and, inside of the cube, 0.1 m to the left.
    assert!((body.volume - (0.008 + 0.2 * 0.01)).abs() < 1e-12, "{}", body.volume);
    let (low, high) = body.solid.mesh.vertices.iter().fold((0.0_f64, 0.0_f64), |(l, h), v| {
        let x = (body.pose.rotation * v + body.pose.translation.vector).x;
        (l.min(x), h.max(x))
    });
    assert!((low + 0.1).abs() < 1e-9 && (high - 0.3).abs() < 1e-9, "{low} to {high}");
    assert!(body.hulls.len() >= 2, "hollow corners are not filled");
    let apart = parts.replace("position = [0.1,", "position = [0.5,");
    let said = from_text(&text, &[&apart]).expect_err("apart").to_string();
    assert!(said.contains("body.cube.parts") && said.contains("part 1 does not overlap"), "{said}");
    let round = "{ shape = { kind = \"sphere\", radius = 0.1, segments = 256 } },";
    let many = format!("body.cube.parts=[{}]", round.repeat(9));
    let said = from_text(&text, &[&many]).expect_err("too many").to_string();
    assert!(said.contains("triangles; at most 200000 are taken"), "{said}");
    let both = errors_of(SMALL, &[parts]);
    assert!(both.contains("body.cube.parts") && both.contains("not both"), "{both}");
}

#[test]
fn a_hit_has_settings_of_its_own_also_by_an_override() {
    let hits = "[[hit]]\nbody = \"cube\"\nat = \"250 ms\"\nseed = 5\nspacing = \"4 mm\"\n\
                [[hit]]\nbody = \"cube.3.12\"\nsolver = \"geometric\"\n";
    let scene = loaded(hits);
    let [first, second] = &scene.directions.hits[..] else { panic!("two hits") };
    assert_eq!((first.at, first.seed, first.spacing), (0.25, Some(5), Some(0.004)));
    assert_eq!(first.to_string(), "seed 5, spacing 0.004 m");
    assert_eq!((second.body.as_str(), second.at), ("cube.3.12", 0.0));
    assert_eq!(second.to_string(), "solver geometric");
    assert!(scene.is_directed());
    // An override changes the entry of a body, or makes one; of two rivals the later one counts.
    let text = with("[[hit]]\nbody = \"cube\"\nspacing = \"4 mm\"\n");
    let set = ["hit.cube.particles=9000", "hit.\"cube.3\".seed=7", "hit.\"cube.3\".at=\"1 s\""];
    let scene = from_text(&text, &set).unwrap_or_else(|why| panic!("{why}"));
    let told: Vec<String> = scene.directions.hits.iter().map(ToString::to_string).collect();
    assert_eq!(told, ["9000 particles", "seed 7"]);
    assert_eq!((scene.directions.hits[0].at, scene.directions.hits[1].at), (0.0, 1.0));
}

#[test]
fn what_is_wrong_with_a_hit_is_said_with_its_place() {
    for (more, words) in [
        ("body = \"cub\"\nseed = 1", ["hit[0].body", "did you mean `cube`"]),
        ("body = \"cube.x\"\nseed = 1", ["hit[0].body", "there is no body \"cube.x\""]),
        ("body = \"ball\"\nseed = 1", ["hit[0].body", "\"ball\" does not break"]),
        ("body = \"cube\"", ["hit[0]", "says nothing about the hit: give it one of `seed`"]),
        ("body = \"cube\"\nat = -1\nseed = 1", ["hit[0].at", "at least 0 s"]),
        ("body = \"cube\"\nspacing = 0", ["hit[0].spacing", "above 0 m"]),
        ("body = \"cube\"\nparticles = 3", ["hit[0].particles", "at least 64"]),
        (
            "body = \"cube\"\nparticles = 300\nspacing = 0.01",
            ["hit[0]", "takes `spacing` or `particles`, not both"],
        ),
        ("body = \"cube\"\nsolver = \"ductile\"", ["hit[0].solver", "takes only what yields"]),
        (
            "body = \"cube\"\nseed = 1\n[[hit]]\nbody = \"cube\"\nsolver = \"geometric\"",
            ["hit[1]", "a second entry is for the hit of \"cube\" from 0 s on"],
        ),
    ] {
        refused(&[(&format!("[[hit]]\n{more}\n"), &words[..])]);
    }
    let set = ["hit.\"cube.7\".seed=3"];
    let twin = format!(
        "{}[[body]]\nname = \"cube.7\"\nshape = {{ kind = \"box\", size = [0.1, 0.1, 0.1] }}\n\
         position = [5, 5, 5]\nmaterial = \"plaster\"\n",
        with("")
    );
    let said = errors_of(&twin, &set);
    assert!(said.contains("can be that body or a fragment of \"cube\""), "{said}");
    let said = errors_of(SMALL, &["hit.cub.seed=3"]);
    assert!(said.contains("--set:1:5") && said.contains("did you mean `cube`"), "{said}");
}
