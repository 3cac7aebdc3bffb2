// The test scene by OpenGL 4.5: a shadow pass nobody reads, the scene into a target of its own, a post pass and a HUD.
// Ends by itself after the number of frames that it is given.
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "gl_shaders.hpp"
#include "scene.hpp"

namespace {

[[noreturn]] void fail(const char* why) {
  std::fprintf(stderr, "gl_application: %s\n", why);
  std::exit(1);
}

struct Surface {
  Display* display = nullptr;
  ::Window window = 0;
  GLXContext context = nullptr;
};

Surface open_window() {
  Surface out;
  out.display = XOpenDisplay(nullptr);
  if (out.display == nullptr) fail("no display");
  const int wanted[] = {GLX_RENDER_TYPE, GLX_RGBA_BIT, GLX_DOUBLEBUFFER, True, GLX_DEPTH_SIZE, 24, None};
  int count = 0;
  GLXFBConfig* const configurations = glXChooseFBConfig(out.display, DefaultScreen(out.display), wanted, &count);
  if (count == 0) fail("no framebuffer configuration");
  XVisualInfo* const visual = glXGetVisualFromFBConfig(out.display, configurations[0]);
  const ::Window root = RootWindow(out.display, visual->screen);
  XSetWindowAttributes attributes{};
  attributes.colormap = XCreateColormap(out.display, root, visual->visual, AllocNone);
  out.window = XCreateWindow(out.display, root, 0, 0, scene::kWidth, scene::kHeight, 0, visual->depth, InputOutput,
                             visual->visual, CWColormap, &attributes);
  XMapWindow(out.display, out.window);
  using Create = GLXContext (*)(Display*, GLXFBConfig, GLXContext, Bool, const int*);
  const auto create =
      reinterpret_cast<Create>(glXGetProcAddressARB(reinterpret_cast<const GLubyte*>("glXCreateContextAttribsARB")));
  const int version[] = {
      GLX_CONTEXT_MAJOR_VERSION_ARB,    4,   GLX_CONTEXT_MINOR_VERSION_ARB, 5, GLX_CONTEXT_PROFILE_MASK_ARB,
      GLX_CONTEXT_CORE_PROFILE_BIT_ARB, None};
  out.context = create(out.display, configurations[0], nullptr, True, version);
  if (out.context == nullptr) fail("no OpenGL 4.5");
  glXMakeCurrent(out.display, out.window, out.context);
  return out;
}

GLuint compile(const char* vertex, const char* fragment) {
  const GLuint program = glCreateProgram();
  for (const auto& [kind, text] : {std::pair{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}}) {
    const GLuint shader = glCreateShader(kind);
    const std::string source = std::string(text).substr(std::string(text).find("#version"));
    const char* const pointer = source.c_str();
    glShaderSource(shader, 1, &pointer, nullptr);
    glCompileShader(shader);
    GLint compiled = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    char log[1024] = "";
    glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    if (compiled == 0) fail(log);
    glAttachShader(program, shader);
  }
  glLinkProgram(program);
  return program;
}

struct Target {
  GLuint framebuffer = 0, colour = 0;
};

Target make_target(GLsizei width, GLsizei height, bool with_colour) {
  Target out;
  GLuint depth = 0;
  glCreateFramebuffers(1, &out.framebuffer);
  glCreateTextures(GL_TEXTURE_2D, 1, &depth);
  glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, width, height);
  glNamedFramebufferTexture(out.framebuffer, GL_DEPTH_ATTACHMENT, depth, 0);
  if (with_colour) {
    glCreateTextures(GL_TEXTURE_2D, 1, &out.colour);
    glTextureStorage2D(out.colour, 1, GL_RGBA8, width, height);
    glNamedFramebufferTexture(out.framebuffer, GL_COLOR_ATTACHMENT0, out.colour, 0);
  } else {
    glNamedFramebufferDrawBuffer(out.framebuffer, GL_NONE);
  }
  return out;
}

GLuint make_texture(const std::vector<std::uint8_t>& texels) {
  GLuint out = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &out);
  glTextureStorage2D(out, 1, GL_SRGB8_ALPHA8, scene::kTextureSide, scene::kTextureSide);
  glTextureSubImage2D(out, 0, 0, 0, scene::kTextureSide, scene::kTextureSide, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
  glTextureParameteri(out, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  return out;
}

struct Buffers {
  GLuint vertices = 0, indices = 0, instances = 0, camera = 0, object = 0;
};

Buffers make_buffers() {
  Buffers out;
  glCreateBuffers(5, &out.vertices);
  GLuint array = 0;
  glGenVertexArrays(1, &array);
  glBindVertexArray(array);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, out.indices);
  const GLint sizes[] = {3, 3, 2, 1};
  std::size_t offset = 0;
  glBindBuffer(GL_ARRAY_BUFFER, out.vertices);
  for (GLuint i = 0; i < 4; ++i) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): offsets into buffers are pointers there
    glVertexAttribPointer(i, sizes[i], GL_FLOAT, GL_FALSE, sizeof(scene::Vertex), reinterpret_cast<void*>(offset));
    glEnableVertexAttribArray(i);
    offset += sizeof(float) * static_cast<std::size_t>(sizes[i]);
  }
  glBindBuffer(GL_ARRAY_BUFFER, out.instances);
  glVertexAttribPointer(4, 3, GL_FLOAT, GL_FALSE, 3 * sizeof(float), nullptr);
  glVertexAttribDivisor(4, 1);
  glEnableVertexAttribArray(4);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, out.camera);
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, out.object);
  return out;
}

template <typename T>
void fill(GLuint buffer, const T* values, std::size_t count) {
  glNamedBufferData(buffer, static_cast<GLsizeiptr>(count * sizeof(T)), values, GL_DYNAMIC_DRAW);
}

void draw(const scene::Part& part, const Buffers& buffers) {
  struct {
    scene::Matrix model;
    float settings[4];
  } const object{part.model, {part.discards ? 0.5f : 0, scene::opacity(part), part.skinned ? 1.0f : 0, 0}};
  fill(buffers.object, &object, 1);
  part.two_sided ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
  part.blends ? glEnable(GL_BLEND) : glDisable(GL_BLEND);
  glDepthMask(part.blends ? GL_FALSE : GL_TRUE);
  glDepthFunc(part.blends ? GL_LEQUAL : GL_LESS);
  const GLenum kinds[] = {GL_TRIANGLES, GL_TRIANGLE_STRIP, GL_TRIANGLE_FAN};
  const GLenum kind = kinds[static_cast<int>(part.topology)];
  const auto count = static_cast<GLsizei>(part.count), instances = static_cast<GLsizei>(part.instances);
  if (part.indexed) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): the same
    const auto at = reinterpret_cast<const void*>(std::size_t{part.first} * 2);
    glDrawElementsInstancedBaseVertexBaseInstance(kind, count, GL_UNSIGNED_SHORT, at, instances, part.base_vertex,
                                                  part.first_instance);
  } else {
    glDrawArraysInstancedBaseInstance(kind, static_cast<GLint>(part.first), count, instances, part.first_instance);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // As games print colours; whoever records must not take them for a part of their own lines.
  std::fputs("\033[0;;m", stdout);
  std::fflush(stdout);
  const int frames = argc > 1 ? std::atoi(argv[1]) : 1000;
  const Surface window = open_window();
  const GLuint scene_program = compile(kSceneVertex, kSceneFragment);
  const GLuint screen_program = compile(kScreenVertex, kScreenFragment);
  const Target shadow = make_target(1024, 1024, false), target = make_target(scene::kWidth, scene::kHeight, true);
  const Buffers buffers = make_buffers();
  const GLuint texture = make_texture(scene::make_texture()), decal = make_texture(scene::make_decal_texture());
  glTextureParameteri(target.colour, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glEnable(GL_PRIMITIVE_RESTART_FIXED_INDEX);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  for (int frame = 0; frame < frames; ++frame) {
    const float time = static_cast<float>(frame) / 30;
    const scene::Scene made = scene::make_scene(time);
    const scene::Camera camera = scene::make_camera(time, false);
    fill(buffers.vertices, made.vertices.data(), made.vertices.size());
    fill(buffers.indices, made.indices.data(), made.indices.size());
    fill(buffers.instances, made.instances.data(), made.instances.size());
    fill(buffers.camera, &camera, 1);
    glUseProgram(scene_program);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glBindTextureUnit(2, texture);
    glBindFramebuffer(GL_FRAMEBUFFER, shadow.framebuffer);
    glViewport(0, 0, 1024, 1024);
    glClear(GL_DEPTH_BUFFER_BIT);
    for (const scene::Part& part : made.parts) {
      if (!part.blends) draw(part, buffers);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    glViewport(0, 0, scene::kWidth, scene::kHeight);
    glClearColor(0.5f, 0.6f, 0.8f, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (const scene::Part& part : made.parts) {
      glBindTextureUnit(2, part.decal ? decal : texture);
      draw(part, buffers);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glUseProgram(screen_program);
    glBindTextureUnit(2, target.colour);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glViewport(8, 8, 40, 20);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glXSwapBuffers(window.display, window.window);
  }
  return 0;
}
