# Run by `cmake --install`: installs the headers that users of the libraries include, and all that these include.
# Everything else is the libraries' own. Takes RAYGRAPH_SOURCE_DIR and RAYGRAPH_INCLUDE_DIR (relative to the prefix).

cmake_policy(VERSION 3.25)

set(public
    editor/session/explain/noise.h
    editor/session/explain/path_text.h
    editor/session/file/content_hash.h
    editor/session/file/merge.h
    editor/session/session.h
    editor/session/verify/verify.h
    editor/viewport/viewport.h
    editor/viewport/vulkan_interop.h
    renderer/gpu_scene/camera_record.h
    renderer/gpu_scene/gpu_scene.h
    renderer/gpu_scene/host_objects.h
    renderer/graph/pass_harness.h
    renderer/graph/plan_text.h
    renderer/graph/readback_values.h
    renderer/graph/renderer.h
    renderer/image/exr.h
    renderer/image/image.h
    renderer/scene/model/camera_view.h
    renderer/scene/model/check.h
    renderer/scene/animation/deform.h
    renderer/scene/gltf/file_access.h
    renderer/scene/gltf/load_gltf.h
    renderer/scene/animation/pose.h
    renderer/scene/gltf/still_scene.h
    renderer/scene/gltf/save_gltf.h
    renderer/scene/model/scene_data.h
    renderer/scene/model/variants.h
    rhi/blas_builder.h
    rhi/command_list.h
    rhi/pipeline.h
    rhi/device.h
    rhi/transfer.h
    rhi/reflection.h
    rhi/shader_compiler.h
    rhi/texture_table.h
    rhi/timestamps.h
    rhi/tlas.h
    shaders/embedded.h)
# What a pass binds, and what it returns, is all for others to use.
file(GLOB folders RELATIVE ${RAYGRAPH_SOURCE_DIR}
    ${RAYGRAPH_SOURCE_DIR}/base/*.h ${RAYGRAPH_SOURCE_DIR}/passes/*.h ${RAYGRAPH_SOURCE_DIR}/shaders/shared/*.h)
# The first needs {fmt}, which hosts do not; the others are for this tree.
list(REMOVE_ITEM folders base/text.h base/os.h base/embed_file.h)
set(todo ${public} ${folders})
set(done)
while(todo)
    list(POP_FRONT todo header)
    if(header IN_LIST done)
        continue()
    endif()
    list(APPEND done ${header})
    get_filename_component(folder ${header} DIRECTORY)
    file(INSTALL DESTINATION ${CMAKE_INSTALL_PREFIX}/${RAYGRAPH_INCLUDE_DIR}/${folder} TYPE FILE
        FILES ${RAYGRAPH_SOURCE_DIR}/${header})
    file(STRINGS ${RAYGRAPH_SOURCE_DIR}/${header} includes REGEX "^#include \"")
    foreach(include IN LISTS includes)
        string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" include "${include}")
        if(EXISTS ${RAYGRAPH_SOURCE_DIR}/${folder}/${include})
            list(APPEND todo ${folder}/${include})
        else()
            list(APPEND todo ${include})
        endif()
    endforeach()
endwhile()
