# A courtyard with columns, fences, spheres, trees of alpha-tested cards and instanced grass, whose camera walks by a
# fixed step a frame: depth pre-pass, shadow maps, normal maps and instances as Godot draws them.
extends Spatial

var camera = Camera.new()
var wheel = Spatial.new()
var step = 0
var random = RandomNumberGenerator.new()

func textured(size, kind):
	var image = Image.new()
	image.create(size, size, true, Image.FORMAT_RGBA8)
	image.lock()
	for y in range(size):
		for x in range(size):
			image.set_pixel(x, y, texel(kind, float(x) / size, float(y) / size))
	image.unlock()
	image.generate_mipmaps()
	var texture = ImageTexture.new()
	texture.create_from_image(image, Texture.FLAG_MIPMAPS | Texture.FLAG_FILTER | Texture.FLAG_REPEAT)
	return texture

func texel(kind, u, v):
	var noise = random.randf() * 0.12
	if kind == "bricks":
		var row = floor(v * 8)
		var across = fposmod(u * 4 + 0.5 * fmod(row, 2), 1.0)
		if fposmod(v * 8, 1.0) < 0.1 or across < 0.05:
			return Color(0.7 + noise, 0.68 + noise, 0.63 + noise)
		return Color(0.55 + noise, 0.25 + noise * 0.5, 0.18 + noise * 0.5)
	if kind == "paving":
		var joint = fposmod(u * 6, 1.0) < 0.06 or fposmod(v * 6, 1.0) < 0.06
		return Color(0.3, 0.3, 0.28) if joint else Color(0.58 + noise, 0.56 + noise, 0.5 + noise)
	if kind == "bricks_normal":
		var fall = 0.5 - 0.35 * cos(v * 8 * TAU) * float(fposmod(v * 8, 1.0) < 0.2)
		return Color(0.5, fall, 1.0)
	if kind == "leaves":
		var held = sin(u * 37 + 3 * sin(v * 21)) * sin(v * 41 + 2 * sin(u * 17)) > -0.1
		var inside = pow(u - 0.5, 2) + pow(v - 0.5, 2) < 0.24
		return Color(0.15 + noise, 0.4 + 2 * noise, 0.1, 1.0 if held and inside else 0.0)
	var blade = abs(fposmod(u * 5, 1.0) - 0.5) < 0.4 * v
	return Color(0.25 + noise, 0.5 + noise, 0.15, 1.0 if blade else 0.0)

func material(kind, bumps = ""):
	var made = SpatialMaterial.new()
	made.albedo_texture = textured(128, kind)
	made.uv1_scale = Vector3(1, 1, 1)
	made.roughness = 0.8
	if bumps != "":
		made.normal_enabled = true
		made.normal_texture = textured(128, bumps)
	if kind == "leaves" or kind == "grass":
		made.params_use_alpha_scissor = true
		made.params_alpha_scissor_threshold = 0.5
		made.params_cull_mode = SpatialMaterial.CULL_DISABLED
	return made

func put(mesh, surface, place, parent = self):
	var node = MeshInstance.new()
	node.mesh = mesh
	node.material_override = surface
	node.transform = place
	parent.add_child(node)
	return node

func at(x, y, z, turn = 0.0):
	return Transform(Basis(Vector3(0, 1, 0), turn), Vector3(x, y, z))

func box(size):
	var mesh = CubeMesh.new()
	mesh.size = size
	return mesh

func grass(surface):
	var blades = MultiMesh.new()
	blades.transform_format = MultiMesh.TRANSFORM_3D
	var card = QuadMesh.new()
	card.size = Vector2(0.7, 0.5)
	blades.mesh = card
	blades.instance_count = 1500
	for i in range(1500):
		var x = random.randf_range(-14, 14)
		var z = random.randf_range(-26, -6)
		blades.set_instance_transform(i, at(x, 0.25, z, random.randf() * TAU))
	var node = MultiMeshInstance.new()
	node.multimesh = blades
	node.material_override = surface
	add_child(node)

func _ready():
	random.seed = 7
	var bricks = material("bricks", "bricks_normal")
	var paving = material("paving")
	paving.uv1_scale = Vector3(20, 20, 1)
	var leaves = material("leaves")
	var ground = PlaneMesh.new()
	ground.size = Vector2(60, 60)
	put(ground, paving, at(0, 0, -15))
	put(box(Vector3(30, 6, 0.5)), bricks, at(0, 3, -28))
	put(box(Vector3(0.5, 4, 24)), bricks, at(-15, 2, -16))
	var metal = SpatialMaterial.new()
	metal.albedo_color = Color(0.8, 0.6, 0.3)
	metal.metallic = 0.9
	metal.roughness = 0.3
	var column = CylinderMesh.new()
	column.top_radius = 0.35
	column.bottom_radius = 0.45
	column.height = 5
	var ball = SphereMesh.new()
	for i in range(9):
		put(column, bricks, at(-12 + 3 * i, 2.5, -20))
		put(ball, metal, at(-12 + 3 * i, 5.8, -20))
	for i in range(60):
		put(box(Vector3(0.05, 1.1, 0.05)), metal, at(-12 + 0.4 * i, 0.55, -9))
	for y in [0.4, 1.0]:
		put(box(Vector3(24, 0.04, 0.04)), metal, at(0, y, -9))
	var card = QuadMesh.new()
	card.size = Vector2(3, 3)
	for tree in range(6):
		put(box(Vector3(0.25, 3, 0.25)), bricks, at(-11 + 4.4 * tree, 1.5, -14))
		for i in range(7):
			put(card, leaves, at(-11 + 4.4 * tree, 3.2 + 0.2 * i, -14, 0.9 * i + tree))
	grass(material("grass"))
	wheel.transform = at(4, 2.2, -7)
	add_child(wheel)
	for i in range(12):
		put(box(Vector3(0.06, 1.8, 0.06)), metal, Transform(Basis(Vector3(0, 0, 1), i * PI / 12), Vector3()), wheel)
	var sun = DirectionalLight.new()
	sun.rotation_degrees = Vector3(-50, 35, 0)
	sun.shadow_enabled = true
	add_child(sun)
	camera.fov = 60
	add_child(camera)
	camera.current = true

# By frames, not by seconds: what is captured does not depend on how fast the machine draws.
func _process(_delta):
	step += 1
	camera.look_at_from_position(Vector3(-3 + 0.02 * step, 2.0, 1), Vector3(0.5, 2.0, -14), Vector3(0, 1, 0))
	wheel.rotation.z = 0.03 * step
