//! Meshes of bodies: keys in the model file, supported files, and imports.

use stiction_core::spatial::Vec3;
use stiction_format::{ImportOptions, Mesh, MeshFormat, ModelFile, Source, import, read};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn model(visual: &str) -> ModelFile {
    let text = format!(
        "gravity = [0, 0, -9.81]\n[bodies.arm]\nmass = 1\ncom = [0.1, 0, 0]\ninertia = [0.01, 0.01, 0.01]\n{visual}\n\
         [joints.pivot]\ntype = \"R\"\nfrom = \"ground\"\nto = \"arm\"\naxis = \"y\"\n"
    );
    let source = Source::new("arm.toml", text);
    read(&source, &|_| Err("no files".into())).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

#[test]
fn meshes_have_scale_and_pose() {
    let mut model = model(
        "visual = [{ mesh = \"a.obj\", scale = [1e-3, 1e-3, 2e-3], position = [\"10 mm\", 0, 0], \
         rotation = { axis = \"z\", angle = \"90 deg\" } }, { mesh = \"a.obj\" }]",
    );
    let (reads, warnings) = (std::cell::Cell::new(0), model.warnings.iter().count());
    model.load_meshes(&|file| {
        reads.set(reads.get() + 1);
        if file == "a.obj" { Ok(TRIANGLE.into()) } else { Err("no such file".into()) }
    });
    assert_eq!((reads.get(), model.warnings.iter().count()), (1, warnings));
    let [first, second] = model.visuals.as_slice() else { panic!("{:?}", model.visuals) };
    assert_eq!((first.body.0, first.scale), (1, [1e-3, 1e-3, 2e-3]));
    let corner = first.pose.apply(Vec3::new(1.0, 0.0, 0.0));
    assert!((corner - Vec3::new(0.01, 1.0, 0.0)).norm() < 1e-15, "{corner:?}");
    let mesh = first.mesh.as_ref().unwrap();
    assert_eq!((mesh.format, mesh.bytes.as_slice()), (MeshFormat::Obj, TRIANGLE.as_bytes()));
    assert_eq!(second.mesh.as_ref(), first.mesh.as_ref());
    assert_eq!(second.scale, [1.0; 3]);
}

/// A mesh that cannot be shown causes a warning with its place, once for each file; the model
/// remains valid.
#[test]
fn meshes_that_cannot_be_shown_are_warned_of() {
    let mut model =
        model("visual = [{ mesh = \"a.step\" }, { mesh = \"b.stl\" }, { mesh = \"b.stl\" }]");
    model.load_meshes(&|file| {
        if file == "a.step" { Ok(vec![]) } else { Err("no such file".into()) }
    });
    assert!(model.visuals.iter().all(|visual| visual.mesh.is_none()));
    let text = model.warnings.render(false);
    assert!(
        text.contains("the mesh `a.step` cannot be shown: only STL, OBJ, glTF and GLB"),
        "{text}"
    );
    assert_eq!(text.matches("the mesh `b.stl` cannot be shown: no such file").count(), 1, "{text}");
    assert!(text.contains("arm.toml:6:"), "{text}");
}

fn glb(json: &str) -> Vec<u8> {
    let json = format!("{json}{}", " ".repeat((4 - json.len() % 4) % 4));
    let mut bytes = b"glTF".to_vec();
    for number in [2, 20 + json.len() as u32, json.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes
}

/// Contents that a page could not show, or not in finite time, are refused.
#[test]
fn hostile_meshes_are_refused() {
    let asset = r#""asset": { "version": "2.0" }"#;
    let gltf = |rest: &str| format!("{{ {asset}, {rest} }}");
    let ring = gltf(
        r#""nodes": [{ "children": [1] }, { "children": [0] }], "scenes": [{ "nodes": [0] }]"#,
    );
    let twice = gltf(r#""nodes": [{ "children": [1, 1] }, {}], "scenes": [{ "nodes": [0] }]"#);
    let lost = gltf(r#""nodes": [{ "children": [7] }]"#);
    let huge = gltf(r#""accessors": [{ "count": 0 }, { "count": 4000000000 }]"#);
    let broken = gltf(r#""accessors": [{ "count": 5e8 }]"#);
    let remote = gltf(r#""buffers": [{ "uri": "https://example.com/data.bin", "byteLength": 4 }]"#);
    let draco = gltf(r#""extensionsRequired": ["KHR_draco_mesh_compression"]"#);
    let nodes = gltf(&format!("\"nodes\": [{}{{}}]", "{},".repeat(5000)));
    for (text, reason) in [
        (ring.as_str(), "a root of a scene has a parent"),
        (&twice, "a node has two parents"),
        (&lost, "a child that does not exist"),
        (&huge, "4000000000 elements; at most 4000000"),
        (&broken, "a count of its elements is not a whole number"),
        (&remote, "its data are in the file `https://example.com/data.bin`"),
        (&draco, "it needs the extension `KHR_draco_mesh_compression`"),
        (&nodes, "it has 5001 nodes"),
        ("{}", "it is not glTF 2.0"),
        ("no JSON", "it is not glTF"),
        (&"[".repeat(10_000), "it is not glTF"),
    ] {
        for (name, bytes) in [("a.gltf", text.into()), ("a.GLB", glb(text))] {
            let why = Mesh::new(name, bytes).unwrap_err();
            assert!(why.contains(reason), "{reason}: {why}");
        }
    }
    // Viewers would use a second JSON chunk.
    let mut two = glb(&gltf("\"nodes\": []"));
    let second = two[12..].to_vec();
    two.extend(second);
    assert!(Mesh::new("a.glb", two).unwrap_err().contains("two JSON chunks"));
    let cut = |length| Mesh::new("a.glb", glb(&gltf("\"nodes\": []"))[..length].to_vec());
    assert!((0..40).all(|length| cut(length).is_err()));
    assert!(Mesh::new("a.glb", glb(&gltf("\"nodes\": []"))).is_ok());
    for (name, text) in
        [("a.obj", "v nan 0 0\nf 1 1 1\n"), ("a.obj", "v 0 0 0\nf 1 2 3\n"), ("a.stl", "")]
    {
        assert!(Mesh::new(name, text.into()).is_err(), "{name}: {text}");
    }
    let large = Mesh::new("a.obj", TRIANGLE.repeat(300_000).into()).unwrap_err();
    assert!(large.contains("at most 8.4 MB are shown"), "{large}");
}

/// An import keeps references to meshes whose files exist, with their scale and pose, and omits all
/// others.
#[test]
fn imports_keep_meshes() {
    let inertia = r#"<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>"#;
    let urdf = format!(
        r#"<robot name="r"><link name="base"/><link name="arm"><inertial>{inertia}</inertial>
        <visual><origin xyz="0 0 0.5" rpy="0 0 1.5707963267948966"/><geometry>
        <mesh filename="package://r/arm.stl" scale="0.001 0.001 0.001"/></geometry></visual>
        <visual><geometry><mesh filename="lost.stl"/></geometry></visual>
        <visual><geometry><box size="1 1 1"/></geometry></visual></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>"#
    );
    let mjcf = r#"<mujoco model="r"><compiler meshdir="package://r"/><asset>
        <mesh name="m" file="arm.stl" scale="0.001 0.001 0.001"/></asset><worldbody>
        <body name="arm"><joint name="j"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <geom type="mesh" mesh="m" pos="0 0 0.5" quat="0.7071067811865476 0 0 0.7071067811865476"/>
        <geom type="mesh" mesh="m" group="3"/></body></worldbody></mujoco>"#;
    let sdf = r#"<sdf version="1.7"><model name="r"><link name="base"/><link name="arm">
        <visual name="v"><pose>0 0 0.5 0 0 1.5707963267948966</pose><geometry><mesh>
        <uri>package://r/arm.stl</uri><scale>0.001 0.001 0.001</scale></mesh></geometry></visual></link>
        <joint name="f" type="fixed"><parent>world</parent><child>base</child></joint>
        <joint name="j" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
        </model></sdf>"#;
    for text in [urdf.as_str(), mjcf, sdf] {
        let files = |file: &str| match file {
            "package://r/arm.stl" => Ok(vec![0; 84]),
            _ => Err("no such file".to_owned()),
        };
        let imported = import(&Source::new("r.xml", text), ImportOptions::default(), &files);
        let imported = imported.unwrap_or_else(|errors| panic!("{}", errors.render(false)));
        let model = read(&Source::new("r.toml", imported.text.as_str()), &|_| Err("".into()));
        let model = model.unwrap_or_else(|errors| panic!("{}", errors.render(false)));
        let [visual] = model.visuals.as_slice() else { panic!("{}", imported.text) };
        assert_eq!(visual.file, "package://r/arm.stl");
        assert_eq!(model.mechanism.bodies()[visual.body.0].name, "arm");
        assert_eq!(visual.scale, [1e-3; 3]);
        let corner = visual.pose.apply(Vec3::new(1.0, 0.0, 0.0));
        assert!(
            (corner - Vec3::new(0.0, 1.0, 0.5)).norm() < 1e-12,
            "{}: {corner:?}",
            imported.text
        );
    }
}
