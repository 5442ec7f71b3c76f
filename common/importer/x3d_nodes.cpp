#include "common/importer/x3d_nodes.h"

#include <set>
#include <vector>

#include "common/importer/xml_text.h"

namespace haptics {
namespace {

std::set<std::string_view> setOf(std::string_view names) {
  const std::vector<std::string_view> words = wordsIn(names);
  return {words.begin(), words.end()};
}

}  // namespace

const std::map<std::string_view, std::string_view>& x3dNodesReadAs() {
  static const std::map<std::string_view, std::string_view> names{{"Collision", "Group"},
                                                                  {"Anchor", "Group"},
                                                                  {"Billboard", "Group"},
                                                                  {"CADAssembly", "Group"},
                                                                  {"CADLayer", "Group"},
                                                                  {"CADFace", "Group"},
                                                                  {"PickableGroup", "Group"},
                                                                  {"HAnimSegment", "Group"},
                                                                  {"Layer", "Group"},
                                                                  {"LayerSet", "Group"},
                                                                  {"Viewport", "Group"},
                                                                  {"CADPart", "Transform"},
                                                                  {"HAnimHumanoid", "Transform"},
                                                                  {"HAnimJoint", "Transform"},
                                                                  {"HAnimSite", "Transform"},
                                                                  {"EspduTransform", "Transform"},
                                                                  {"CoordinateDouble", "Coordinate"},
                                                                  {"LOD", "Group"},
                                                                  {"Switch", "Group"},
                                                                  {"StaticGroup", "Group"},
                                                                  {"Inline", "Group"},
                                                                  {"IndexedLineSet", "PointSet"},
                                                                  {"LineSet", "PointSet"}};
  return names;
}

bool isUnfeltX3dNode(std::string_view name) {
  static const std::set<std::string_view> names = setOf(R"(
Appearance AcousticProperties Material TwoSidedMaterial PhysicalMaterial UnlitMaterial FillProperties LineProperties
PointProperties ImageTexture MovieTexture PixelTexture MultiTexture MultiTextureCoordinate MultiTextureTransform
TextureProperties TextureTransform ImageTextureAtlas ImageTexture3D PixelTexture3D ComposedTexture3D
TextureTransform3D TextureTransformMatrix3D TextureCoordinate TextureCoordinate3D TextureCoordinate4D
TextureCoordinateGenerator NurbsTextureCoordinate ComposedCubeMapTexture GeneratedCubeMapTexture ImageCubeMapTexture
TextureProjector TextureProjectorParallel TextureProjectorPoint FontStyle ScreenFontStyle Color ColorRGBA Normal
Tangent FogCoordinate FloatVertexAttribute Matrix3VertexAttribute Matrix4VertexAttribute ComposedShader PackagedShader
ProgramShader ShaderPart ShaderProgram Background TextureBackground Fog LocalFog DirectionalLight PointLight SpotLight
EnvironmentLight Viewpoint OrthoViewpoint GeoViewpoint ViewpointGroup NavigationInfo WorldInfo Sound AudioClip
SpatialSound ListenerPointSource AudioDestination AudioBufferSource OscillatorSource StreamAudioSource
MicrophoneSource StreamAudioDestination Gain Delay Convolver BiquadFilter Analyser ChannelMerger ChannelSelector
ChannelSplitter DynamicsCompressor WaveShaper PeriodicWave BufferAudioSource MetadataBoolean MetadataDouble
MetadataFloat MetadataInteger MetadataSet MetadataString GeoMetadata GeoOrigin Script TimeSensor TouchSensor
GeoTouchSensor ProximitySensor GeoProximitySensor VisibilitySensor PlaneSensor CylinderSensor SphereSensor KeySensor
StringSensor LoadSensor LinePickSensor PointPickSensor PrimitivePickSensor VolumePickSensor CollisionSensor
BooleanFilter BooleanSequencer BooleanToggle BooleanTrigger IntegerSequencer IntegerTrigger TimeTrigger
ColorInterpolator CoordinateInterpolator CoordinateInterpolator2D NormalInterpolator OrientationInterpolator
PositionInterpolator PositionInterpolator2D ScalarInterpolator EaseInEaseOut SplinePositionInterpolator
SplinePositionInterpolator2D SplineScalarInterpolator SquadOrientationInterpolator GeoPositionInterpolator
NurbsOrientationInterpolator NurbsPositionInterpolator NurbsSurfaceInterpolator ColorChaser ColorDamper
CoordinateChaser CoordinateDamper OrientationChaser OrientationDamper PositionChaser PositionChaser2D PositionDamper
PositionDamper2D ScalarChaser ScalarDamper TexCoordChaser2D TexCoordDamper2D DISEntityManager DISEntityTypeMapping
ReceiverPdu SignalPdu TransmitterPdu HAnimMotion HAnimDisplacer ClipPlane Layout LayoutLayer LayoutGroup
CollisionCollection CollisionSpace CollidableOffset RigidBodyCollection RigidBody Contact BallJoint
DoubleAxisHingeJoint MotorJoint SingleAxisHingeJoint SliderJoint UniversalJoint BoundedPhysicsModel ConeEmitter
ExplosionEmitter ForcePhysicsModel ParticleSystem PointEmitter PolylineEmitter SurfaceEmitter VolumeEmitter
WindPhysicsModel ROUTE IMPORT EXPORT IS ProtoDeclare ExternProtoDeclare component meta)");
  return names.contains(name);
}

bool isFeltX3dNode(std::string_view name) {
  static const std::set<std::string_view> names = setOf(R"(
X3D head unit Scene Group Transform Shape Box Cone Cylinder Sphere IndexedFaceSet IndexedTriangleSet
IndexedTriangleStripSet IndexedTriangleFanSet TriangleSet TriangleStripSet TriangleFanSet ElevationGrid Extrusion
Arc2D ArcClose2D Circle2D Disk2D Polyline2D Rectangle2D TriangleSet2D Coordinate GeoCoordinate PointSet)");
  return names.contains(name) || x3dNodesReadAs().contains(name);
}

}  // namespace haptics
