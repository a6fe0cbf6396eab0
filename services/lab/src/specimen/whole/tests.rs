use super::super::{Specimen, Subject, load};

const HEAD: &str = r#"
[scene.world]
duration = 0.1
[[scene.body]]
name = "floor"
shape = { kind = "box", size = [4, 4, 1] }
position = [0, 0, -0.5]
material = "granite"
fixed = true
[[scene.stack]]
name = "block"
count = 2
offset = [0, 0, 0.1]
body.shape = { kind = "box", size = ["10 cm", "10 cm", "10 cm"] }
body.position = [0, 0, "5 cm"]
body.material = "plaster"
"#;

fn read(text: &str, overrides: &[&str]) -> Result<Specimen, String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("ground.toml"), "[world]\nduration = 0.2\n").expect("a file");
    let file = folder.path().join("thing.toml");
    std::fs::write(&file, text).expect("a file");
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    load(&file, &overrides).map_err(|errors| errors.to_string())
}

/// Each error names the line of its value, in the scene and around it.
#[test]
fn errors_name_their_place_and_bound() {
    let cases = [
        ("[[scene.body]]\nname = \"x\"", "17:1", "scene.body.x: `material` is missing"),
        ("[scene.worlds]\nx = 1", "17:8", "unknown key `worlds`"),
        ("[scene.fracture]\nmax_fragments = 1", "18:17", "must be at least 2; it is 1"),
        ("[solver]\nspacing = 1", "17:2", "unknown key `solver`"),
        ("[[probe]]\nname = \"p\"\nkind = \"masse\"", "19:8", "did you mean `mass`"),
        (
            "[[probe]]\nname = \"p\"\nkind = \"mass\"\nbody = \"blok\"",
            "20:8",
            "did you mean `block`",
        ),
        (
            "[[probe]]\nname = \"p\"\nkind = \"hits\"\nother = \"x\"",
            "20:9",
            "the scene has no body \"x\"",
        ),
        (
            "[[probe]]\nname = \"p\"\nkind = \"spin\"\nbody = \"floor\"",
            "17:1",
            "`component` is missing",
        ),
        (
            "[[probe]]\nname = \"p\"\nkind = \"momentum\"\ncomponent = \"xx\"",
            "20:13",
            "a vector has x, y, z and size",
        ),
        (
            "[[probe]]\nname = \"p\"\nkind = \"inertia\"\nbody = \"block\"\ncomponent = \"mises\"",
            "21:13",
            "no equivalent of von Mises",
        ),
        (
            "[[probe]]\nname = \"p\"\nkind = \"balance\"\nbody = \"block\"",
            "20:8",
            "takes no `body`, nor any other key",
        ),
        (
            "[[probe]]\nname = \"p\"\nkind = \"hit-speed\"\nbody = \"block\"\nnth = 0",
            "21:7",
            "must be at least 1; it is 0",
        ),
        ("[[metric]]\nname = \"m\"\nprobe = \"p\"\nreduce = \"max\"", "19:9", "no probe \"p\""),
        ("[expect.m]\nvalue = 1", "17:1", "no metric \"m\""),
    ];
    for (tail, place, wanted) in cases {
        let why = read(&format!("{HEAD}{tail}"), &[]).expect_err(tail);
        assert!(why.contains(wanted), "{tail}\n{why}");
        assert!(why.contains(&format!("thing.toml:{place}")), "{tail}\n{why}");
    }
}

/// `scene.` in an override is the scene; the rest is around it, and what is wrong with either
/// reported.
#[test]
fn overrides_reach_the_scene_and_what_is_around_it() {
    let specimen = read(HEAD, &["scene.world.step=1/60 s", "run.ends=refused"]).expect("it loads");
    let Subject::Whole(whole) = &specimen.subject else { panic!("{specimen:?}") };
    assert_eq!(whole.overrides, ["world.step=1/60 s"]);
    assert!((whole.step - 1.0 / 60.0).abs() < 1e-15, "{}", whole.step);
    let plain = read(HEAD, &[]).expect("it loads");
    assert_ne!(plain.id(), specimen.id());
    for (wrong, wanted) in [
        ("scene.world.stepp=1", "scene.world.stepp: unknown key"),
        ("scene.world.step=1", "must be at most 0.05 s; it is 1 s"),
        ("scene.body.bal.fixed=true", "the scene has no body \"bal\""),
        ("world.step=0.01", "there is no `world`"),
    ] {
        let why = read(HEAD, &[wrong]).expect_err(wrong);
        assert!(why.contains(wanted), "{wrong}\n{why}");
    }
}

/// A scene that is in another file is brought in by `include`, and what is written here wins.
#[test]
fn a_scene_may_include_another() {
    let with =
        HEAD.replace("[scene.world]\nduration = 0.1", "[scene]\ninclude = [\"ground.toml\"]");
    let specimen = read(&with, &[]).expect("it loads");
    assert!(matches!(specimen.subject, Subject::Whole(_)));
    let none = with.replace("ground", "sky");
    let why = read(&none, &[]).expect_err("there is no such file");
    assert!(why.contains("sky.toml"), "{why}");
}

/// A body that cannot be made or has no room is reported beside a specimen that was read; what is
/// wrong with the file, a mesh that is not there too, is still an error.
#[test]
fn a_scene_that_cannot_be_made_is_a_flaw_and_no_error() {
    let text = format!("{HEAD}[[probe]]\nname = \"p\"\nkind = \"mass\"\nbody = \"block\"\n");
    let with = |more: &[&str]| read(&text, more);
    assert_eq!(with(&[]).expect("it loads").flaw, None);
    let low = "scene.stack.block.body.position=[0,0,0]";
    let ring = "scene.body.floor.shape={kind=\"torus\",ring_radius=1,tube_radius=2}";
    let flawed = with(&[low]).expect("it loads");
    assert_eq!(flawed.probes.len(), 1);
    let flaw = flawed.flaw.clone().expect("a flaw");
    assert!(flaw.starts_with("scene.stack.block.position: \"block-0\" overlaps"), "{flaw}");
    let other = with(&[ring]).expect("it loads");
    let flaw = other.flaw.clone().expect("a flaw");
    assert!(flaw.starts_with("scene.body.floor.shape: torus minor radius is 2"), "{flaw}");
    assert_ne!(flawed.id(), other.id());
    for (more, wanted) in [
        (["scene.world.stepp=1", ring], "unknown key `stepp`"),
        (["run.ens=ok", ring], "unknown key `ens`"),
        (["scene.body.floor.shape=1", low], "must be a table"),
    ] {
        let why = with(&more).expect_err(wanted);
        assert!(why.contains(wanted), "{why}");
    }
    let mesh = text.replace("shape = { kind = \"box\", size = [4, 4, 1] }", "mesh = \"no.obj\"");
    let why = read(&mesh, &[]).expect_err("there is no such file");
    assert!(why.contains("thing.toml:6:8: scene.body.floor.mesh: cannot read"), "{why}");
}
