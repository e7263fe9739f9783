import raygraph as rg
scene = rg.load("scenes/cornell.gltf")
picture = rg.render(scene, spp=16, size=(96, 96), exposure=1)
picture.save("cornell.png")
