<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="de" sourcelanguage="en">
 <context>
  <name>TsolidPreferences</name>
  <message>
   <source>Building</source>
   <translation>Bauen</translation>
  </message>
  <message>
   <source>Default</source>
   <translation>Standard</translation>
  </message>
  <message>
   <source>Element faces are cut into flat pieces until they are so near to the true ones</source>
   <translation>Elementflächen werden in ebene Stücke zerlegt, bis sie den wahren so nahe sind</translation>
  </message>
  <message>
   <source>Fewer keep the computer free for other work; the result is the same</source>
   <translation>Weniger lassen den Rechner für anderes frei; das Ergebnis ist dasselbe</translation>
  </message>
  <message>
   <source>Finest drawing, in parts of the size</source>
   <translation>Feinste Zeichnung, in Teilen der Größe</translation>
  </message>
  <message>
   <source>General</source>
   <translation>Allgemein</translation>
  </message>
  <message>
   <source>How long to work on the shape of the elements inside</source>
   <translation>Wie lange an der Form der Elemente im Innern gearbeitet wird</translation>
  </message>
  <message>
   <source>Looking inside</source>
   <translation>Hineinsehen</translation>
  </message>
  <message>
   <source>None</source>
   <translation>Keine</translation>
  </message>
  <message>
   <source>Processors to use (0: all)</source>
   <translation>Prozessoren (0: alle)</translation>
  </message>
  <message>
   <source>Quick</source>
   <translation>Schnell</translation>
  </message>
  <message>
   <source>Smoothing effort of new solids</source>
   <translation>Glättung neuer Körper</translation>
  </message>
  <message>
   <source>Thorough</source>
   <translation>Gründlich</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Assembly</name>
  <message>
   <source>Check assembly</source>
   <translation>Baugruppe prüfen</translation>
  </message>
  <message>
   <source>Watertight contacts, gaps and clashes between parts</source>
   <translation>Wasserdichte Kontakte, Spalte und Durchdringungen zwischen Teilen</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Build</name>
  <message>
   <source>Build</source>
   <translation>Bauen</translation>
  </message>
  <message>
   <source>Fill the part with hex blocks whose borders are its own faces</source>
   <translation>Das Teil mit Hexaederblöcken füllen, deren Ränder seine eigenen Flächen sind</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Check</name>
  <message>
   <source>Can the part become hex blocks, and where not?</source>
   <translation>Kann das Teil zu Hexaederblöcken werden, und wo nicht?</translation>
  </message>
  <message>
   <source>Check</source>
   <translation>Prüfen</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Example</name>
  <message>
   <source>Open this example part in a new document</source>
   <translation>Dieses Beispielteil in einem neuen Dokument öffnen</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Export</name>
  <message>
   <source>Export...</source>
   <translation>Exportieren...</translation>
  </message>
  <message>
   <source>Write the report or the solid to a file</source>
   <translation>Bericht oder Körper in eine Datei schreiben</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_HexBlocks</name>
  <message>
   <source>Hexahedra for FEM: conforming, with nodes on the part's faces</source>
   <translation>Hexaeder für FEM: durchgehend, mit Knoten auf den Flächen des Teils</translation>
  </message>
  <message>
   <source>Mesh with hex blocks</source>
   <translation>Mit Hexaedern vernetzen</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_LookInside</name>
  <message>
   <source>Cut open, peel and colour the hex blocks</source>
   <translation>Die Hexaederblöcke aufschneiden, schälen und färben</translation>
  </message>
  <message>
   <source>Look inside</source>
   <translation>Hineinsehen</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Manual</name>
  <message>
   <source>How to use this workbench, with pictures</source>
   <translation>Wie man diesen Arbeitsbereich benutzt, mit Bildern</translation>
  </message>
  <message>
   <source>Solid T-spline manual</source>
   <translation>Handbuch zu Volumen-T-Splines</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Rebuild</name>
  <message>
   <source>Build again after the part has changed</source>
   <translation>Neu bauen, nachdem sich das Teil geändert hat</translation>
  </message>
  <message>
   <source>Rebuild</source>
   <translation>Neu bauen</translation>
  </message>
 </context>
 <context>
  <name>Tsolid_Report</name>
  <message>
   <source>Report</source>
   <translation>Bericht</translation>
  </message>
  <message>
   <source>What was proved and measured, face by face</source>
   <translation>Was bewiesen und gemessen wurde, Fläche für Fläche</translation>
  </message>
 </context>
 <context>
  <name>Workbench</name>
  <message>
   <source>Example parts</source>
   <translation>Beispielteile</translation>
  </message>
  <message>
   <source>Solid T-spline</source>
   <translation>Volumen-T-Spline</translation>
  </message>
 </context>
 <context>
  <name>tsolid</name>
  <message>
   <source>%d of 8 picked: %s</source>
   <translation>%d von 8 gewählt: %s</translation>
  </message>
  <message>
   <source>%s has no part to be rebuilt from.</source>
   <translation>%s hat kein Teil, aus dem es neu gebaut werden könnte.</translation>
  </message>
  <message>
   <source>%s has no shape: select a solid.</source>
   <translation>%s hat keine Form: bitte einen Körper auswählen.</translation>
  </message>
  <message>
   <source>%s has not been built yet: rebuild it.</source>
   <translation>%s ist noch nicht gebaut: bitte neu bauen.</translation>
  </message>
  <message>
   <source>%s is a mesh: a solid with spline faces is needed.</source>
   <translation>%s ist ein Netz: gebraucht wird ein Körper mit Spline-Flächen.</translation>
  </message>
  <message>
   <source>%s is a sketch: select the solid that is made of it.</source>
   <translation>%s ist eine Skizze: bitte den Körper auswählen, der aus ihr entsteht.</translation>
  </message>
  <message>
   <source>%s is empty: recompute it or select a solid.</source>
   <translation>%s ist leer: bitte neu berechnen oder einen Körper auswählen.</translation>
  </message>
  <message>
   <source>%s is not a length</source>
   <translation>%s ist keine Länge</translation>
  </message>
  <message>
   <source>%s is not a number</source>
   <translation>%s ist keine Zahl</translation>
  </message>
  <message>
   <source>%s is not a solid T-spline: Build makes one of it.</source>
   <translation>%s ist kein Volumen-T-Spline: Bauen macht einen daraus.</translation>
  </message>
  <message>
   <source>%s: %d hexahedra, %d nodes, worst scaled Jacobian %.3g</source>
   <translation>%s: %d Hexaeder, %d Knoten, schlechteste skalierte Jacobi-Determinante %.3g</translation>
  </message>
  <message>
   <source>20 nodes (quadratic)</source>
   <translation>20 Knoten (quadratisch)</translation>
  </message>
  <message>
   <source>8 nodes (linear)</source>
   <translation>8 Knoten (linear)</translation>
  </message>
  <message>
   <source>Allowed</source>
   <translation>Erlaubt</translation>
  </message>
  <message>
   <source>An assembly has two solids or more: %d found. Select them, or nothing to take all.</source>
   <translation>Eine Baugruppe hat mindestens zwei Volumenkörper: %d gefunden. Diese auswählen, oder nichts, um alle zu nehmen.</translation>
  </message>
  <message>
   <source>Automatic</source>
   <translation>Automatisch</translation>
  </message>
  <message>
   <source>Bezier hexahedra</source>
   <translation>Bézier-Hexaeder</translation>
  </message>
  <message>
   <source>Blocks across the core</source>
   <translation>Blöcke quer durch den Kern</translation>
  </message>
  <message>
   <source>Borders of the hex blocks</source>
   <translation>Ränder der Hexaederblöcke</translation>
  </message>
  <message>
   <source>Build</source>
   <translation>Bauen</translation>
  </message>
  <message>
   <source>Build...</source>
   <translation>Bauen...</translation>
  </message>
  <message>
   <source>Built, but not proved everywhere: %d of %d hex blocks are undecided.</source>
   <translation>Gebaut, aber nicht überall bewiesen: %d von %d Hexaederblöcken sind unentschieden.</translation>
  </message>
  <message>
   <source>Cancel</source>
   <translation>Abbrechen</translation>
  </message>
  <message>
   <source>Cancelled.</source>
   <translation>Abgebrochen.</translation>
  </message>
  <message>
   <source>Check</source>
   <translation>Prüfen</translation>
  </message>
  <message>
   <source>Check assembly</source>
   <translation>Baugruppe prüfen</translation>
  </message>
  <message>
   <source>Check with these</source>
   <translation>Mit diesen prüfen</translation>
  </message>
  <message>
   <source>Checking the faces</source>
   <translation>Flächen werden geprüft</translation>
  </message>
  <message>
   <source>Chosen automatically.</source>
   <translation>Automatisch gewählt.</translation>
  </message>
  <message>
   <source>Clashes</source>
   <translation>Durchdringungen</translation>
  </message>
  <message>
   <source>Click one in the view</source>
   <translation>Bitte eines in der Ansicht anklicken</translation>
  </message>
  <message>
   <source>Click the vertices that have to be corners.</source>
   <translation>Die Punkte anklicken, die Ecken sein sollen.</translation>
  </message>
  <message>
   <source>Click vertices of the part in the view: up to eight corners</source>
   <translation>Ecken des Teils in der Ansicht anklicken: bis zu acht</translation>
  </message>
  <message>
   <source>Colours</source>
   <translation>Farben</translation>
  </message>
  <message>
   <source>Comparing with the CAD faces</source>
   <translation>Vergleich mit den CAD-Flächen</translation>
  </message>
  <message>
   <source>Conformal contact faces</source>
   <translation>Passgenaue Kontaktflächen</translation>
  </message>
  <message>
   <source>Continuity</source>
   <translation>Stetigkeit</translation>
  </message>
  <message>
   <source>Control net</source>
   <translation>Kontrollnetz</translation>
  </message>
  <message>
   <source>Copied.</source>
   <translation>Kopiert.</translation>
  </message>
  <message>
   <source>Copy as text</source>
   <translation>Als Text kopieren</translation>
  </message>
  <message>
   <source>Corners</source>
   <translation>Ecken</translation>
  </message>
  <message>
   <source>Cut along the blocks</source>
   <translation>Entlang der Blöcke schneiden</translation>
  </message>
  <message>
   <source>Cut open across</source>
   <translation>Aufschneiden quer zu</translation>
  </message>
  <message>
   <source>Default</source>
   <translation>Standard</translation>
  </message>
  <message>
   <source>Draw sides and corners</source>
   <translation>Seiten und Ecken zeichnen</translation>
  </message>
  <message>
   <source>Eight corners</source>
   <translation>Acht Ecken</translation>
  </message>
  <message>
   <source>Element</source>
   <translation>Element</translation>
  </message>
  <message>
   <source>Element size</source>
   <translation>Elementgröße</translation>
  </message>
  <message>
   <source>Export</source>
   <translation>Exportieren</translation>
  </message>
  <message>
   <source>Export...</source>
   <translation>Exportieren...</translation>
  </message>
  <message>
   <source>Faces</source>
   <translation>Flächen</translation>
  </message>
  <message>
   <source>Faces that are no farther apart are reported, in millimetres</source>
   <translation>Flächen, die höchstens so weit auseinander sind, werden gemeldet, in Millimetern</translation>
  </message>
  <message>
   <source>Filling the part</source>
   <translation>Das Teil wird gefüllt</translation>
  </message>
  <message>
   <source>Finish what is open in the task panel first.</source>
   <translation>Bitte zuerst beenden, was im Aufgabenbereich offen ist.</translation>
  </message>
  <message>
   <source>Free faces</source>
   <translation>Freie Flächen</translation>
  </message>
  <message>
   <source>Gaps between parts</source>
   <translation>Spalte zwischen Teilen</translation>
  </message>
  <message>
   <source>Gaps up to</source>
   <translation>Spalte bis</translation>
  </message>
  <message>
   <source>Grading</source>
   <translation>Abstufung</translation>
  </message>
  <message>
   <source>Halve the spans of the faces so often: exact, more hex blocks</source>
   <translation>Die Abschnitte der Flächen so oft halbieren: exakt, mehr Blöcke</translation>
  </message>
  <message>
   <source>Hex blocks</source>
   <translation>Hexaederblöcke</translation>
  </message>
  <message>
   <source>Hex blocks across the core of the part, at least</source>
   <translation>Mindestens so viele Blöcke quer durch den Kern des Teils</translation>
  </message>
  <message>
   <source>Hex blocks do not fold (det J &gt; 0)</source>
   <translation>Hexaederblöcke falten sich nicht (det J &gt; 0)</translation>
  </message>
  <message>
   <source>How long to work on the shape of the hex blocks inside</source>
   <translation>Wie lange an der Form der Blöcke im Innern gearbeitet wird</translation>
  </message>
  <message>
   <source>Incomplete: %d of %d parts have no solid.</source>
   <translation>Unvollständig: %d von %d Teilen haben keinen Volumenkörper.</translation>
  </message>
  <message>
   <source>Into analysis</source>
   <translation>In Analyse</translation>
  </message>
  <message>
   <source>Laying out the hex blocks</source>
   <translation>Die Blöcke werden angelegt</translation>
  </message>
  <message>
   <source>Look inside</source>
   <translation>Hineinsehen</translation>
  </message>
  <message>
   <source>Making the spline functions</source>
   <translation>Die Spline-Funktionen entstehen</translation>
  </message>
  <message>
   <source>Measured</source>
   <translation>Gemessen</translation>
  </message>
  <message>
   <source>Measuring</source>
   <translation>Messen</translation>
  </message>
  <message>
   <source>Mesh</source>
   <translation>Vernetzen</translation>
  </message>
  <message>
   <source>Mesh with hex blocks</source>
   <translation>Mit Hexaedern vernetzen</translation>
  </message>
  <message>
   <source>Meshed</source>
   <translation>Vernetzt</translation>
  </message>
  <message>
   <source>No parts touch.</source>
   <translation>Keine Teile berühren sich.</translation>
  </message>
  <message>
   <source>Nodes</source>
   <translation>Knoten</translation>
  </message>
  <message>
   <source>None</source>
   <translation>Keine</translation>
  </message>
  <message>
   <source>Not as it is: %d things stand in the way.</source>
   <translation>So noch nicht: %d Dinge stehen im Weg.</translation>
  </message>
  <message>
   <source>Not as it is: 1 thing stands in the way.</source>
   <translation>So noch nicht: 1 Sache steht im Weg.</translation>
  </message>
  <message>
   <source>Not valid (%s): do not use this solid.</source>
   <translation>Ungültig (%s): diesen Volumenkörper nicht verwenden.</translation>
  </message>
  <message>
   <source>Not watertight: gaps of up to %.6g.</source>
   <translation>Nicht wasserdicht: Spalte bis zu %.6g.</translation>
  </message>
  <message>
   <source>Notes</source>
   <translation>Hinweise</translation>
  </message>
  <message>
   <source>Of edges that carry none of their own, in the part's unit</source>
   <translation>Für Kanten ohne eigene, in der Einheit des Teils</translation>
  </message>
  <message>
   <source>Options</source>
   <translation>Optionen</translation>
  </message>
  <message>
   <source>Out of date: the solid has been rebuilt since.</source>
   <translation>Veraltet: der Volumenkörper wurde seitdem neu gebaut.</translation>
  </message>
  <message>
   <source>Parts</source>
   <translation>Teile</translation>
  </message>
  <message>
   <source>Parts penetrate each other: %d clashes.</source>
   <translation>Teile durchdringen sich: %d Durchdringungen.</translation>
  </message>
  <message>
   <source>Peel off layers</source>
   <translation>Schichten abschälen</translation>
  </message>
  <message>
   <source>Pick</source>
   <translation>Wählen</translation>
  </message>
  <message>
   <source>Preparing the view</source>
   <translation>Die Ansicht wird vorbereitet</translation>
  </message>
  <message>
   <source>Preview</source>
   <translation>Vorschau</translation>
  </message>
  <message>
   <source>Proving that nothing folds</source>
   <translation>Beweis, dass sich nichts faltet</translation>
  </message>
  <message>
   <source>Quick</source>
   <translation>Schnell</translation>
  </message>
  <message>
   <source>Reading the faces</source>
   <translation>Flächen werden gelesen</translation>
  </message>
  <message>
   <source>Rebuild</source>
   <translation>Neu bauen</translation>
  </message>
  <message>
   <source>Refine the faces</source>
   <translation>Flächen verfeinern</translation>
  </message>
  <message>
   <source>Report</source>
   <translation>Bericht</translation>
  </message>
  <message>
   <source>Result</source>
   <translation>Ergebnis</translation>
  </message>
  <message>
   <source>Scaled Jacobian</source>
   <translation>Skalierte Jacobi-Determinante</translation>
  </message>
  <message>
   <source>Select a solid T-spline first; Build makes one of a part.</source>
   <translation>Bitte zuerst einen Volumen-T-Spline auswählen; Bauen macht einen aus einem Teil.</translation>
  </message>
  <message>
   <source>Select one object only: %d are selected.</source>
   <translation>Bitte nur ein Objekt auswählen: %d sind ausgewählt.</translation>
  </message>
  <message>
   <source>Select one part only: %d objects are selected.</source>
   <translation>Bitte nur ein Teil auswählen: %d Objekte sind ausgewählt.</translation>
  </message>
  <message>
   <source>Select the part first: one solid, in the tree or in the view.</source>
   <translation>Bitte zuerst das Teil auswählen: einen Körper, im Baum oder in der Ansicht.</translation>
  </message>
  <message>
   <source>Shape of the hex blocks</source>
   <translation>Form der Hexaederblöcke</translation>
  </message>
  <message>
   <source>Show</source>
   <translation>Zeigen</translation>
  </message>
  <message>
   <source>Show the whole part</source>
   <translation>Das ganze Teil zeigen</translation>
  </message>
  <message>
   <source>Six sides of the hex blocks</source>
   <translation>Sechs Seiten der Hexaederblöcke</translation>
  </message>
  <message>
   <source>Size</source>
   <translation>Größe</translation>
  </message>
  <message>
   <source>Smoothing effort</source>
   <translation>Glättung</translation>
  </message>
  <message>
   <source>Smoothing the hex blocks</source>
   <translation>Die Blöcke werden geglättet</translation>
  </message>
  <message>
   <source>Smoothness inside</source>
   <translation>Glattheit im Inneren</translation>
  </message>
  <message>
   <source>Solid</source>
   <translation>Körper</translation>
  </message>
  <message>
   <source>Solid T-spline</source>
   <translation>Volumen-T-Spline</translation>
  </message>
  <message>
   <source>Solid T-spline manual</source>
   <translation>Handbuch zu Volumen-T-Splines</translation>
  </message>
  <message>
   <source>Starting</source>
   <translation>Start</translation>
  </message>
  <message>
   <source>Stopping</source>
   <translation>Wird angehalten</translation>
  </message>
  <message>
   <source>Storing</source>
   <translation>Speichern</translation>
  </message>
  <message>
   <source>T-mesh</source>
   <translation>T-Netz</translation>
  </message>
  <message>
   <source>T-spline functions</source>
   <translation>T-Spline-Funktionen</translation>
  </message>
  <message>
   <source>The add-on works with a library written in C, which must be of the same version. In the folder of tsolid's sources, run

    cmake -S . -B build &amp;&amp; cmake --build build
    cmake --install build --component addon --prefix "%s"

and start FreeCAD again.</source>
   <translation>Das Add-on arbeitet mit einer in C geschriebenen Bibliothek derselben Version. Bitte im Ordner der Quellen von tsolid ausführen:

    cmake -S . -B build &amp;&amp; cmake --build build
    cmake --install build --component addon --prefix "%s"

und FreeCAD neu starten.</translation>
  </message>
  <message>
   <source>The document was closed: the work on it was stopped.</source>
   <translation>Das Dokument wurde geschlossen: die Arbeit daran wurde angehalten.</translation>
  </message>
  <message>
   <source>The part is gone.</source>
   <translation>Das Teil ist nicht mehr da.</translation>
  </message>
  <message>
   <source>The part was deleted: the work on it was stopped.</source>
   <translation>Das Teil wurde gelöscht: die Arbeit daran wurde angehalten.</translation>
  </message>
  <message>
   <source>The solid is gone.</source>
   <translation>Der Volumenkörper ist nicht mehr da.</translation>
  </message>
  <message>
   <source>The solid that %s was made of is gone.</source>
   <translation>Der Volumenkörper, aus dem %s gemacht wurde, ist nicht mehr da.</translation>
  </message>
  <message>
   <source>There is not enough memory for this.</source>
   <translation>Dafür reicht der Speicher nicht.</translation>
  </message>
  <message>
   <source>Thickness of the outermost layer over that of the innermost</source>
   <translation>Dicke der äußersten Schicht im Verhältnis zur innersten</translation>
  </message>
  <message>
   <source>Thorough</source>
   <translation>Gründlich</translation>
  </message>
  <message>
   <source>Time</source>
   <translation>Zeit</translation>
  </message>
  <message>
   <source>Tolerance of edges</source>
   <translation>Toleranz der Kanten</translation>
  </message>
  <message>
   <source>Valid: %d hex blocks, none folds; worst scaled Jacobian %.3g.</source>
   <translation>Gültig: %d Hexaederblöcke, keiner faltet sich; schlechteste skalierte Jacobi-Determinante %.3g.</translation>
  </message>
  <message>
   <source>Verdict</source>
   <translation>Urteil</translation>
  </message>
  <message>
   <source>Volume</source>
   <translation>Volumen</translation>
  </message>
  <message>
   <source>Wanted length of the hexahedra's edges, in millimetres</source>
   <translation>Gewünschte Kantenlänge der Hexaeder in Millimetern</translation>
  </message>
  <message>
   <source>Watertight, and like a cube</source>
   <translation>Wasserdicht und wie ein Würfel</translation>
  </message>
  <message>
   <source>Watertight: %d contacts, %d of them proved to be one surface.</source>
   <translation>Wasserdicht: %d Kontakte, davon %d bewiesen als eine Fläche.</translation>
  </message>
  <message>
   <source>Web page</source>
   <translation>Webseite</translation>
  </message>
  <message>
   <source>What</source>
   <translation>Was</translation>
  </message>
  <message>
   <source>What stands in the way</source>
   <translation>Was im Weg steht</translation>
  </message>
  <message>
   <source>Where</source>
   <translation>Wo</translation>
  </message>
  <message>
   <source>Written: %s</source>
   <translation>Geschrieben: %s</translation>
  </message>
  <message>
   <source>Yes: this part can become hex blocks.</source>
   <translation>Ja: aus diesem Teil können Hexaederblöcke werden.</translation>
  </message>
  <message>
   <source>a hundredth of the smaller part</source>
   <translation>ein Hundertstel des kleineren Teils</translation>
  </message>
  <message>
   <source>a part lies inside another</source>
   <translation>ein Teil liegt in einem anderen</translation>
  </message>
  <message>
   <source>a part touches itself</source>
   <translation>ein Teil berührt sich selbst</translation>
  </message>
  <message>
   <source>a twentieth of the part</source>
   <translation>ein Zwanzigstel des Teils</translation>
  </message>
  <message>
   <source>about %d s left</source>
   <translation>noch etwa %d s</translation>
  </message>
  <message>
   <source>area of inner faces: continuous</source>
   <translation>Fläche innen: stetig</translation>
  </message>
  <message>
   <source>area of inner faces: curvature too</source>
   <translation>Fläche innen: auch krümmungsstetig</translation>
  </message>
  <message>
   <source>area of inner faces: tangent planes too</source>
   <translation>Fläche innen: auch tangentenstetig</translation>
  </message>
  <message>
   <source>area of inner faces: torn</source>
   <translation>Fläche innen: gerissen</translation>
  </message>
  <message>
   <source>at</source>
   <translation>bei</translation>
  </message>
  <message>
   <source>automatic</source>
   <translation>automatisch</translation>
  </message>
  <message>
   <source>best that the part's faces allow</source>
   <translation>bestes, was die Flächen des Teils zulassen</translation>
  </message>
  <message>
   <source>can become hex blocks</source>
   <translation>kann Hexaederblöcke werden</translation>
  </message>
  <message>
   <source>cannot become hex blocks</source>
   <translation>kann keine Hexaederblöcke werden</translation>
  </message>
  <message>
   <source>control points of the faces kept bit for bit</source>
   <translation>Kontrollpunkte der Flächen Bit für Bit erhalten</translation>
  </message>
  <message>
   <source>distance of the face from the solid</source>
   <translation>Abstand der Fläche vom Volumenkörper</translation>
  </message>
  <message>
   <source>face</source>
   <translation>Fläche</translation>
  </message>
  <message>
   <source>faces, edges, vertices</source>
   <translation>Flächen, Kanten, Ecken</translation>
  </message>
  <message>
   <source>folded</source>
   <translation>gefaltet</translation>
  </message>
  <message>
   <source>free face</source>
   <translation>freie Fläche</translation>
  </message>
  <message>
   <source>functions</source>
   <translation>Funktionen</translation>
  </message>
  <message>
   <source>gap</source>
   <translation>Spalt</translation>
  </message>
  <message>
   <source>hex blocks</source>
   <translation>Hexaederblöcke</translation>
  </message>
  <message>
   <source>hex blocks not proved free of folds</source>
   <translation>Hexaederblöcke ohne Beweis der Faltenfreiheit</translation>
  </message>
  <message>
   <source>holes through the part</source>
   <translation>Löcher durch das Teil</translation>
  </message>
  <message>
   <source>independence of the inner functions (smallest eigenvalue)</source>
   <translation>Unabhängigkeit der inneren Funktionen (kleinster Eigenwert)</translation>
  </message>
  <message>
   <source>independence of the surface functions (smallest eigenvalue)</source>
   <translation>Unabhängigkeit der Oberflächenfunktionen (kleinster Eigenwert)</translation>
  </message>
  <message>
   <source>inner faces less smooth than they should be</source>
   <translation>innere Flächen, die weniger glatt sind als vorgesehen</translation>
  </message>
  <message>
   <source>mean scaled Jacobian</source>
   <translation>mittlere skalierte Jacobi-Determinante</translation>
  </message>
  <message>
   <source>none</source>
   <translation>keine</translation>
  </message>
  <message>
   <source>note</source>
   <translation>Hinweis</translation>
  </message>
  <message>
   <source>ok</source>
   <translation>in Ordnung</translation>
  </message>
  <message>
   <source>on each other within the tolerance</source>
   <translation>aufeinander innerhalb der Toleranz</translation>
  </message>
  <message>
   <source>one piece</source>
   <translation>ein Stück</translation>
  </message>
  <message>
   <source>one surface, after exact refinement</source>
   <translation>eine Fläche, nach exakter Verfeinerung</translation>
  </message>
  <message>
   <source>one surface, in part</source>
   <translation>teilweise eine Fläche</translation>
  </message>
  <message>
   <source>one surface: same functions and control points</source>
   <translation>eine Fläche: gleiche Funktionen und Kontrollpunkte</translation>
  </message>
  <message>
   <source>parts penetrate each other</source>
   <translation>Teile durchdringen sich</translation>
  </message>
  <message>
   <source>refused</source>
   <translation>abgelehnt</translation>
  </message>
  <message>
   <source>relative difference</source>
   <translation>relativer Unterschied</translation>
  </message>
  <message>
   <source>smallest coefficient</source>
   <translation>kleinster Koeffizient</translation>
  </message>
  <message>
   <source>smallest proved bound of det J</source>
   <translation>kleinste bewiesene Schranke von det J</translation>
  </message>
  <message>
   <source>the same part twice in the same place</source>
   <translation>dasselbe Teil zweimal am selben Ort</translation>
  </message>
  <message>
   <source>the size must be a positive length</source>
   <translation>die Größe muss eine positive Länge sein</translation>
  </message>
  <message>
   <source>their sum differs from 1 by</source>
   <translation>ihre Summe weicht von 1 ab um</translation>
  </message>
  <message>
   <source>violations</source>
   <translation>Verletzungen</translation>
  </message>
  <message>
   <source>volume inside the faces</source>
   <translation>Volumen innerhalb der Flächen</translation>
  </message>
  <message>
   <source>volume of the hex blocks</source>
   <translation>Volumen der Hexaederblöcke</translation>
  </message>
  <message>
   <source>warning</source>
   <translation>Warnung</translation>
  </message>
  <message>
   <source>watertight: every edge has two faces</source>
   <translation>wasserdicht: jede Kante hat zwei Flächen</translation>
  </message>
  <message>
   <source>worst scaled Jacobian</source>
   <translation>schlechteste skalierte Jacobi-Determinante</translation>
  </message>
  <message>
   <source>worst, compared with that</source>
   <translation>schlechteste im Vergleich dazu</translation>
  </message>
 </context>
</TS>
