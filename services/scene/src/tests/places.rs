//! Bodies at places that are given one by one.

use super::super::{Scene, load_bundle};
use cullet_document::files::{Bundle, SceneFile};
use cullet_geometry::{Quat, Vec3};
use std::sync::Arc;

fn scene(more: &str, table: &str) -> Result<Scene, String> {
    let text = format!(
        "[[instances]]\nname = \"brick\"\n{more}\n[instances.body]\nmaterial = \"granite\"\n\
         anchor = \"base\"\ngroup = \"pile\"\n\
         shape = {{ kind = \"box\", size = [0.2, 0.1, 0.1] }}\n"
    );
    let file = |key: &str, text: &str| SceneFile {
        key: format!("scene/{key}"),
        bytes: Arc::new(text.as_bytes().to_vec()),
    };
    let files = vec![file("scene.toml", &text), file("places.csv", table)];
    let (name, main) = ("test".to_owned(), "scene/scene.toml".to_owned());
    load_bundle(&Bundle { name, main, overrides: Vec::new(), files })
        .map_err(|errors| errors.to_string())
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.bodies.iter().map(|body| &body.name[..]).collect()
}

#[test]
fn each_place_has_a_body_and_all_share_one_solid() {
    let places = "places = [\n{ position = [0, 0, 0] },\n{ position = [1, 2, \"30 cm\"], \
                  rotation = { axis = [0, 0, 1], degrees = 90 } },\n\
                  { position = [5, 0, 0], name = \"last\" },\n]";
    let made = scene(places, "").expect("loads");
    assert_eq!(names(&made), ["brick-0", "brick-1", "brick-last"]);
    let body = &made.bodies[1];
    let off = body.pose.translation.vector - Vec3::new(1.0, 2.0, 0.35);
    assert!(off.norm() < 1e-12, "its base is at the place: {off}");
    let turn = Quat::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
    assert!(body.pose.rotation.angle_to(&turn) < 1e-12);
    assert!(made.bodies.iter().all(|it| Arc::ptr_eq(&it.solid, &made.bodies[0].solid)));
    assert!(made.bodies.iter().all(|it| it.generator.as_deref() == Some("brick")));
}

/// They are named together by the name of the table, alone by their own.
#[test]
fn joints_glue_and_fields_name_them() {
    let directed = "[[glue]]\nbodies = [\"brick\"]\nforce = 10\n\
                    [[joint]]\nkind = \"rope\"\nat = [0, 0, 3]\n\
                    between = [\"world\", \"brick-1\"]\n\
                    [[field]]\nkind = \"wind\"\nvelocity = [1, 0, 0]\nbodies = [\"pile\"]\n\
                    [expect]\nunbroken = [\"brick-0\"]\n";
    let whole = |name: &str| {
        let text = format!(
            "{directed}[[instances]]\nname = \"{name}\"\n\
             places = [{{ position = [0, 0, 0] }}, {{ position = [0.2, 0, 0] }}]\n\
             [instances.body]\nmaterial = \"granite\"\ngroup = \"pile\"\n\
             shape = {{ kind = \"box\", size = [0.2, 0.1, 0.1] }}\n"
        );
        Scene::parse("test", &text, &[]).map_err(|why| why.to_string())
    };
    let made = whole("brick").expect("loads");
    assert_eq!(made.directions.glue[0].bodies, [0, 1]);
    assert_eq!(made.directions.joints[0].bodies, [None, Some(1)]);
    let said = whole("tile").expect_err("there is no brick");
    assert!(said.contains("there is no body \"brick\""), "{said}");
    assert!(said.contains("there is no body \"brick-1\""), "{said}");
}

#[test]
fn a_table_has_places_turns_and_names() {
    let table = "\u{feff}# from a layout\nname, x, y, z, qw, qx, qy, qz\n\
                 left, 0, 0, 0, 1, 0, 0, 0\r\nright, 1.5, -2, 1e-1, 0, 0, 0, 2\n";
    let made = scene("file = \"places.csv\"", table).expect("loads");
    assert_eq!(names(&made), ["brick-left", "brick-right"]);
    let turn = made.bodies[1].pose.rotation;
    let half = Quat::from_axis_angle(&Vec3::z_axis(), std::f64::consts::PI);
    assert!(turn.angle_to(&half) < 1e-12, "{turn}");
    assert!(made.files.iter().any(|file| file.key == "scene/places.csv"), "it travels along");
    let turned = scene("file = \"places.csv\"", "x,y,z,rx,ry,rz\n0,0,0,0,0,90\n").expect("loads");
    let turn = turned.bodies[0].pose.rotation;
    assert!(turn.angle_to(&Quat::from_euler_angles(0.0, 0.0, 90_f64.to_radians())) < 1e-12);
}

/// A number sign begins a remark above the head alone; rows without a name have their number.
#[test]
fn no_row_of_a_table_is_passed_over() {
    let file = "file = \"places.csv\"";
    let table = "# a remark\n\nname,x,y,z\n#1,0,0,0\n\n,1,0,0\n a ,2,0,0\n";
    let made = scene(file, table).expect("loads");
    assert_eq!(names(&made), ["brick-#1", "brick-1", "brick-a"]);
    let said = scene(file, "x,y,z\n0,0,0\n# a remark\n1,0,0\n").expect_err("no row");
    assert!(said.contains("line 3: it has 1 values where the head has 3"), "{said}");
    let many: String = (0..100).map(|row| format!("a,{row},0,0\n")).collect();
    let said = scene(file, &format!("name,x,y,z\n{many}")).expect_err("twice");
    assert_eq!(said.matches("a second place is called").count(), 20, "{said}");
}

/// What is unusual about a body is said once for all, whatever their names.
#[test]
fn the_first_of_equal_bodies_speaks_for_all() {
    let tall = "[world]\ngravity = [0, 0, -10000]\n";
    let body = "[instances.body]\nmaterial = \"granite\"\n\
                shape = { kind = \"box\", size = [0.2, 0.1, 9] }\n";
    let loaded = |names: [&str; 2]| {
        let [one, two] = names;
        let text = format!(
            "{tall}[[instances]]\nname = \"s\"\nplaces = [{{ position = [0, 0, 0]{one} }}, \
             {{ position = [5, 0, 0]{two} }}]\n{body}"
        );
        let made = Scene::parse("test", &text, &[]).expect("loads");
        let of_body = |line: &&String| line.starts_with("s-");
        made.warnings.iter().filter(of_body).cloned().collect::<Vec<_>>()
    };
    let plain = loaded(["", ""]);
    assert!(plain.len() == 1 && plain[0].starts_with("s-0: "), "{plain:?}");
    let named = loaded([", name = \"a\"", ", name = \"b\""]);
    assert_eq!(named, [plain[0].replacen("s-0", "s-a", 1)]);
}

#[test]
fn what_is_wrong_with_a_place_is_said_with_its_line() {
    let file = "file = \"places.csv\"";
    for (table, words) in [
        ("x,y\n0,0\n", "line 1: it takes all of the columns x, y, z"),
        ("qw,qx,qy,qz\n", "line 1: the columns x, y, z are missing"),
        ("x,y,z,w\n0,0,0,0\n", "line 1: there is no column \"w\"; known: x, y, z, qw"),
        ("x,y,z,x\n0,0,0,0\n", "line 1: a second column is called \"x\""),
        ("x,y,z,rx\n0,0,0,0\n", "line 1: it takes all of the columns rx, ry, rz"),
        ("x,y,z\n", "line 1: no row follows it"),
        ("x,y,z\n0,0,0\n\n1,one,0\n", "line 4: \"one\" in column 2 is no number"),
        ("x,y,z\n0,0,inf\n", "line 2: \"inf\" in column 3 is no number"),
        ("x,y,z\n0,0,0\n0,0\n", "line 3: it has 2 values where the head has 3"),
        (
            "x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0\n",
            "line 2: the quaternion must have a length above 1e-6; it is 0",
        ),
        ("x,y,z,name\n0,0,0,a\n\n1,0,0,a\n", "line 4: a second place is called \"a\""),
        ("x,y,z,name\n0,0,0,a/b\n", "places.csv, line 2: \"brick-a/b\" is no name of a body"),
        ("x,y,z\n0,0,0\n0.1,0,0\n", "\"brick-1\" overlaps \"brick-0\" at the start"),
        ("x,y,z\n200000,0,0\n", "within 100000 m of the origin; one lies at 200000 m"),
    ] {
        let said = scene(file, table).expect_err(table);
        assert!(said.contains(words) && said.contains("instances.brick"), "{table}: {said}");
    }
    let many = format!("x,y,z\n{}", "0,0,0\n".repeat(super::super::places::MOST_PLACES + 1));
    let said = scene(file, &many).expect_err("too many");
    assert!(said.contains("line 100002: at most 100000 places are taken"), "{said}");
    for (more, words) in [
        ("", "`places` or a `file` of them is missing"),
        ("file = \"places.csv\"\nplaces = [{ position = [0, 0, 0] }]", "not both"),
        ("file = \"places.txt\"", "is no table of places"),
        ("file = \"other.csv\"", "other.csv"),
        ("places = [{ name = \"a\" }]", "`position` is missing"),
    ] {
        let said = scene(more, "x,y,z\n0,0,0\n").expect_err(more);
        assert!(said.contains(words) && said.contains("instances.brick"), "{more}: {said}");
    }
}
