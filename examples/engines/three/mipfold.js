// mipfold in three.js: folded mips as they are, and geometric filtering in place of three's own.
//
// For:         three r187 (npm three@0.187.0), WebGLRenderer, MeshStandardMaterial and MeshPhysicalMaterial.
// Include:     mipfold kernels geometric_aa_screen --lang glsl --bundle > geometric_aa_screen.glsl
// Put:         this file beside your modules; see README.md in the folder above.
// Run here:    in Chromium with software WebGL, by tests/gpu/tests/engines.rs.
// Unverified:  hardware GPUs; WebGPURenderer and node materials, which never call onBeforeCompile.

import { ImageLoader, LinearMipmapLinearFilter, MirroredRepeatWrapping, RepeatWrapping, REVISION, ShaderChunk, Texture } from 'three';

// A map of `mipfold build`'s folder (an URL with a slash at its end): 'normal' and 'roughness' are those of a material's
// normalMap and roughnessMap; manifest.json names the others. Mips go to the GPU as they are: three generates none.
// Browsers give 8 bits of 16-bit PNGs. flipY: false for meshes of GLTFLoader, whose v points down.
export async function foldedMap( folder, role, flipY = true ) {

	const manifest = await ( await fetch( folder + 'manifest.json' ) ).json();
	const map = manifest.maps.find( ( map ) => map.role === role && map.container === 'png' );
	if ( map === undefined ) throw new Error( `mipfold: no PNG with role '${ role }' in ${ folder }manifest.json` );

	const loader = new ImageLoader();
	const mips = await Promise.all( map.files.map( ( file ) => loader.loadAsync( folder + file ) ) );
	const texture = new Texture( mips[ 0 ] );
	texture.mipmaps = mips;
	texture.generateMipmaps = false;
	texture.flipY = flipY;
	texture.minFilter = LinearMipmapLinearFilter;
	if ( manifest.wrap === 'repeat' ) texture.wrapS = texture.wrapT = RepeatWrapping;
	if ( manifest.wrap === 'mirror' ) texture.wrapS = texture.wrapT = MirroredRepeatWrapping;
	texture.needsUpdate = true;
	return texture;

}

// Widens a material by the curvature of its mesh, in place of what three adds to roughness for that. `helpers` is the text
// of geometric_aa_screen.glsl. Of the table in it, for interpolated normals and one roughness:
//   formula 'mf_aa_screen_normal', sigma2 'MF_SIGMA2_PEAK'        least blur (the default)
//   formula 'mf_aa_screen_normal_bound', sigma2 'MF_SIGMA2_HALF'  no sparkle, some blur
// Both are GLSL text, as is `most`. Call it before the material is first drawn.
export function curvatureFiltering( material, helpers, {
	formula = 'mf_aa_screen_normal',
	sigma2 = 'MF_SIGMA2_PEAK',
	most = 'MF_MOST_ADDED',
} = {} ) {

	const widen = `${ formula }( pow( r, 4.0 ), n, ${ sigma2 }, ${ most } )`;

	// Perceptual roughness r, unit normal n: alpha^2 = r^4.
	const functions = `${ helpers }
float mfWidened( const in float r, const in vec3 n ) { return pow( ${ widen }, 0.25 ); }
`;

	const before = material.onBeforeCompile, key = material.customProgramCacheKey();

	material.onBeforeCompile = ( shader, renderer ) => {

		before.call( material, shader, renderer );
		let lights = ShaderChunk.lights_physical_fragment;
		for ( const name of [ 'roughness', 'clearcoatRoughness' ] ) {

			const own = `material.${ name } += geometryRoughness;`;
			lights = replaced( lights, own, `material.${ name } = mfWidened( material.${ name }, nonPerturbedNormal );` );

		}

		const begin = '#include <lights_physical_pars_fragment>', use = '#include <lights_physical_fragment>';
		shader.fragmentShader = replaced( replaced( shader.fragmentShader, begin, begin + '\n' + functions ), use, lights );

	};

	// Materials with equal keys share a program.
	material.customProgramCacheKey = () => key + widen;
	material.needsUpdate = true;
	return material;

}

function replaced( text, part, by ) {

	const found = text.split( part ).length - 1;
	if ( found !== 1 ) throw new Error( `mipfold: the shader of three r${ REVISION } has ${ found } times '${ part }'` );
	return text.replace( part, () => by );

}
